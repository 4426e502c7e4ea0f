"""Safety functions, each with code that breaks it and a test that must notice.

safety_mutants.py check ROOT            every function has a mutant and a test, both exist, and the document has the table
safety_mutants.py table ROOT            the table of docs/failure-modes.md
safety_mutants.py run ROOT BUILD [F..]  breaks one function after another in the source, builds, and expects its tests
                                        to fail; they pass before, and the source is restored after each
"""
import argparse
import json
import pathlib
import re
import signal
import subprocess
import sys

FUNCTIONS = [f"F{number}" for number in range(1, 19)]
DOCUMENT = "docs/failure-modes.md"
KEYS = {"function", "statement", "side", "file", "from", "to", "program", "tests"}
TEST_SECONDS = 300
# Suite.Name, or Instantiation/Suite.Name/*
TEST_NAME = re.compile(r"(?:\w+/)?(\w+)\.(\w+)(?:/\*)?$")


def read_mutants(root):
    return json.loads((root / "tests/house/safety_mutants.json").read_text(encoding="utf-8"))


def test_names(root):
    """Suite.Name of every test of the tree."""
    pattern = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.M)
    names = set()
    for path in (root / "tests").rglob("*_test.cpp"):
        names |= {".".join(found) for found in pattern.findall(path.read_text(encoding="utf-8"))}
    return names


def table(mutants):
    lines = ["| function | what it guarantees | side | broken in | noticed by |", "|---|---|---|---|---|"]
    for mutant in mutants:
        tests = ", ".join(f"`{name}`" for name in mutant["tests"])
        lines.append(f"| {mutant['function']} | {mutant['statement']} | {mutant['side']} | "
                     f"`{mutant['file']}` | {tests} |")
    return "\n".join(lines) + "\n"


def faults(root, mutants):
    """Why the list is not complete or not true of the tree."""
    known = test_names(root)
    for function in FUNCTIONS:
        if not any(mutant["function"] == function for mutant in mutants):
            yield f"{function} has no mutant"
    for mutant in mutants:
        name = f"{mutant.get('function')} in {mutant.get('file')}"
        if set(mutant) != KEYS:
            yield f"{name}: keys {sorted(set(mutant) ^ KEYS)} are missing or unknown"
            continue
        path = root / mutant["file"]
        count = path.read_text(encoding="utf-8").count(mutant["from"]) if path.is_file() else 0
        if count != 1:
            yield f"{name}: the text to replace occurs {count} times, not once: {mutant['from']!r}"
        if mutant["to"] == mutant["from"] or mutant["side"] not in ("host", "robot") or not mutant["tests"]:
            yield f"{name}: nothing is replaced, no test is named, or the side is neither host nor robot"
        for test in mutant["tests"]:
            match = TEST_NAME.match(test)
            if not match or ".".join(match.groups()) not in known:
                yield f"{name}: there is no test {test}"
    if all(set(mutant) == KEYS for mutant in mutants) and table(mutants) not in (root / DOCUMENT).read_text(encoding="utf-8"):
        yield f"{DOCUMENT} has another table than `safety_mutants.py table ROOT` prints"


def pass_tests(build, mutant):
    """Whether the mutant's tests pass; one that hangs fails."""
    command = [build / "bin" / mutant["program"], "--gtest_filter=" + ":".join(mutant["tests"])]
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              timeout=TEST_SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return False
    if "[==========] Running 0 tests" in done.stdout:
        sys.exit(f"{mutant['function']}: {mutant['program']} runs none of {mutant['tests']}")
    return done.returncode == 0


def compile_programs(build, programs):
    """Empty, or why they do not build."""
    done = subprocess.run(["ninja", "-C", build, *sorted(programs)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    return "" if done.returncode == 0 else "it does not build: " + done.stdout[-1500:]


def show_compilation(build, programs):
    """Builds the tree as it is, which may take minutes, with ninja's progress on stderr."""
    if subprocess.run(["ninja", "-C", build, *sorted(programs)], stdout=sys.stderr, check=False).returncode:
        sys.exit("the tree as it is does not build")


def verdict(root, build, mutant):
    """killed, or why not. The source is as it was afterwards, the build is not."""
    path = root / mutant["file"]
    text = path.read_text(encoding="utf-8")
    try:
        path.write_text(text.replace(mutant["from"], mutant["to"]), encoding="utf-8")
        problem = compile_programs(build, {mutant["program"]})
        return problem or ("survives" if pass_tests(build, mutant) else "killed")
    finally:
        path.write_text(text, encoding="utf-8")


def run(root, build, mutants):
    """Number of mutants that are not killed."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # the source is restored then, too
    programs = {mutant["program"] for mutant in mutants}
    show_compilation(build, programs)
    broken = [mutant["tests"] for mutant in mutants if not pass_tests(build, mutant)]
    if broken:
        sys.exit(f"these tests fail on the tree as it is: {broken}")
    alive = 0
    for mutant in mutants:
        result = verdict(root, build, mutant)
        alive += result != "killed"
        print(f"{mutant['function']:<4} {mutant['side']:<6} {mutant['file']:<44} {result}", flush=True)
    show_compilation(build, programs)
    print(f"{len(mutants) - alive} of {len(mutants)} mutants killed")
    return alive


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["check", "table", "run"])
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path, nargs="?")
    parser.add_argument("functions", nargs="*", help="F1 ... F18; all where none is named")
    arguments = parser.parse_args()
    mutants = read_mutants(arguments.root)
    if arguments.what == "table":
        print(table(mutants), end="")
        return 0
    if arguments.what == "check":
        found = list(faults(arguments.root, mutants))
        print("\n".join(found) or f"{len(mutants)} mutants of {len(FUNCTIONS)} safety functions")
        return 1 if found else 0
    if arguments.build is None:
        parser.error("run needs the folder of a build")
    unknown = set(arguments.functions) - set(FUNCTIONS)
    if unknown:
        parser.error(f"no safety function {', '.join(sorted(unknown))}: F1 to F18")
    wanted = arguments.functions or FUNCTIONS
    return 1 if run(arguments.root, arguments.build, [m for m in mutants if m["function"] in wanted]) else 0


if __name__ == "__main__":
    sys.exit(main())
