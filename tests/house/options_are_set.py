"""Options have tiers: few are for users, and every one for experts is set by a test, a benchmark or an application.

    options_are_set.py ROOT COMMAND

COMMAND is the stonestack program. An option counts as set where a file below tests/, apps/, benchmarks/, examples/,
data/ or src/experiment/ (the rows of an experiment) has its whole name (search.beam=5), assigns a member of its name in a file that names its group's struct, or
has its key in a cell file. An option that nothing sets belongs into its room's constants.hpp.
"""
import os
import re
import subprocess
import sys

MOST = 40  # options for users, and as many entries of a cell file; a pose or a lens counts as one

# A member is one of this group's where the file has one of these words.
GROUPS = {
    "detection": r"DetectionOptions|detection\.|options_of",
    "search": r"SearchOptions|search\.|quick\(",
    "motion": r"MotionOptions|motion\.",
    "run": r"BuildOptions|run\.",
    "tracking": r"TrackOptions|tracking\.",
    "simulation": r"SimulationOptions|simulation\.|SimulatedCell",
    "scene": r"SceneOptions|scene\.",
    "arm": r"UrArmOptions|UrArm\b|arm\.|ScriptOptions|ScriptContext|RtdeOptions|RtdeClient|fake_ur",
    "gripper": r"ThreeFingerOptions|ThreeFingerGripper|ModbusOptions|ModbusClient|gripper\.",
    "force_torque": r"FtSensorOptions|FtSensor\b",
    "camera": r"StreamCamera|V4l2Camera|RealsenseCamera|RecordedCamera|FrameCheck",
    "simulators": r"simulate: true|Simulat|Faults|UrServer|faults\.",
}
LENS = {"depth_scale", "width", "height", "fx", "fy", "cx", "cy", "distortion", "k1", "k2", "p1", "p2", "k3"}


def names(command, *arguments):
    text = subprocess.run([command, *arguments], check=True, capture_output=True, text=True).stdout
    return [line.split(":", 1)[0] for line in text.splitlines() if ":" in line]


def entries(cell):
    """Of a cell file: the numbers of a pose, a point, a field or a lens are one."""
    found = set()
    for name in cell:
        group, last = name.rsplit(".", 1) if "." in name else ("", name)
        if re.search(r"\.T_\w+$|\.site$|\.field$|\.workspace$|\.fence$", group):
            found.add(group)
        elif group.startswith("camera.") and last in LENS:
            found.add("camera: lens")
        else:
            found.add(name)
    return found


def sources(root):
    files = {}
    for folder in ("tests", "apps", "benchmarks", "examples", "data", ".ci", "src/experiment"):
        for path, folders, here in os.walk(os.path.join(root, folder)):
            folders[:] = [f for f in folders if f != "corpus"]
            for file in here:
                if file.endswith((".cpp", ".hpp", ".py", ".cmake", ".txt", ".yaml", ".sh")) and file != os.path.basename(__file__):
                    with open(os.path.join(path, file), encoding="utf-8", errors="replace") as text:
                        files[os.path.relpath(os.path.join(path, file), root)] = text.read()
    return files


def is_set(name, files):
    pose = re.match(r"(.*\.T_\w+)\.(?:x|y|z|q[xyzw])$", name)
    name = pose.group(1) if pose else name  # a pose is set as a whole
    last = re.escape(name.rsplit(".", 1)[-1])
    group = GROUPS.get(name.split(".", 1)[0], r"$^")
    whole = re.compile(r"(?<![\w.])" + re.escape(name) + r"(?:\s*=|[\"'`:,\s]|$)", re.M)
    member = re.compile(r"(?:(?:\.|->)" + last + r"\s*(?:=(?!=)|\+=|\*=)|::" + last + r"\b|[{,]\s*\." + last + r"\b|,\s*\"" + last + r"=)")
    inline = re.compile(r"[\s,{\"]" + last + r": \{")
    key = re.compile(r"^\s*" + last + r"\s*:", re.M)
    for path, text in files.items():
        if whole.search(text):
            return True
        if path.endswith((".cpp", ".hpp")) and re.search(group, text) and member.search(text):
            return True
        if pose and re.search(group, text) and inline.search(text):
            return True
        if path.startswith("data/cells") and key.search(text):
            return True
    return False


def main(root, command):
    users, cell = names(command, "config", "show"), names(command, "config", "cell")
    experts = [n for n in names(command, "config", "show", "--expert") if n not in users]
    experts += [n for n in names(command, "config", "cell", "--expert") if n not in cell]
    problems = []
    if len(users) < 10 or len(experts) < 50:
        problems.append(f"only {len(users)} options for users and {len(experts)} for experts: is {command} right?")
    if len(users) > MOST:
        problems.append(f"{len(users)} options for users, more than {MOST}")
    if len(entries(cell)) > MOST:
        problems.append(f"{len(entries(cell))} entries of a cell file for users, more than {MOST}")
    files = sources(root)
    for name in experts:
        if not is_set(name, files):
            problems.append(f"{name}: set by no test, benchmark or application; make it a constant")
    if is_set("search.no_such_option", files):
        problems.append("the check finds what is not there")
    print(f"{len(users)} options and {len(entries(cell))} entries of a cell for users, {len(experts)} for experts")
    if problems:
        sys.exit("\n".join(problems))


main(*sys.argv[1:])
