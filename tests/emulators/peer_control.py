#!/usr/bin/env python3
"""A library that keeps a script on the robot and commands it through RTDE registers: the order of its questions, its
recipes and the odd corners of its text are those of ur_rtde (control, input/output and receive interface); the code and
the script are ours. Standard library only.

peer_control.py RTDE_PORT REALTIME_PORT DASHBOARD_PORT: exits 0 when the robot behaves.
"""
import socket
import struct
import sys
import time

from peer_rtde import HOST, Rtde

SCRIPT = """def resident():
    global int_offset = # int register offset
    global float_offset = # float register offset
    global servo_thread = 0
    global target = [0, 0, 0, 0, 0, 0]
    global time = 0.008

    def read_float(i):
        return read_input_float_register(i + float_offset)
    end
    def read_int(i):
        return read_input_integer_register(i + int_offset)
    end
    def say(i, value):
        write_output_integer_register(i + int_offset, value)
    end
    def joints_from(i):
      q = [0, 0, 0, 0, 0, 0]
      k = 0
      while k < 6:
        q[k] = read_float(i + k)
        k = k + 1
      end
      return q
    end
    def scale(p, factor):
      p[0] = p[0] * factor
      return p
    end
    def path():
      # inject path
    end

    thread follow():
        while (True):
            enter_critical
            q = target
            dt = time
            exit_critical
            servoj(q, t=dt, lookahead_time=0.1, gain=300)
        end
    end

    def process():
        cmd = read_int(0)
        if cmd == 1:
            async = read_int(1)
            movej(joints_from(0), a=read_float(7), v=read_float(6))
        elif cmd == 11:
            q = joints_from(0)
            enter_critical
            target = q
            time = read_float(8)
            exit_critical
            if servo_thread == 0:
                global servo_thread = run follow()
            end
        elif cmd == 16:
            enter_critical
            kill servo_thread
            servo_thread = 0
            exit_critical
            stopl(read_float(0))
        elif cmd == 45:
            path()
        elif cmd == 57:
            enable_external_ft_sensor(False, 0.0, [0, 0, 0], [0, 0, 0])
$5.4    elif cmd == 26:
$5.4        write_output_float_register(float_offset, get_steptime())
        end
        if cmd != 255:
            say(0, 2)
        end
        return cmd != 255
    end

        ######### loop
        textmsg("loaded")
$5.0    force_mode_set_gain_scaling(0.5)
$3.5    force_mode_set_damping(0.025)
        keep_running = True
        executing = False
        say(0, 1)
        while keep_running:
            cmd = read_int(0)
            if cmd == 11 or cmd == 26:
                keep_running = process()
                say(0, 1)
            elif cmd == 0:
                executing = False
                say(0, 1)
            else:
                if not executing:
                    keep_running = process()
                end
                executing = True
            end
            sync()
        end
        textmsg("terminated")
end
"""

RECIPES = [  # counts of int and double registers and other names, as many and as large as there
    (2, 8, []), (1, 11, []), (8, 18, []), (1, 0, []), (1, 9, []), (1, 6, []), (1, 4, []), (1, 1, []), (2, 0, []),
    (1, 14, []), (1, 0, []), (1, 12, []), (1, 8, []), (1, 13, []), (2, 0, []), (1, 13, []), (7, 6, []),
    (1, 0, ["external_force_torque"]), (2, 7, [])]


class Dashboard:
    def __init__(self, port):
        self.file = socket.create_connection((HOST, port), 10).makefile("rw", newline="\n")
        assert self.file.readline().startswith("Connected: Universal Robots Dashboard Server")

    def ask(self, text):
        self.file.write(text + "\n")
        self.file.flush()
        return self.file.readline().strip()


def fit(script, version, offset):
    """Drops the lines that a controller is too old for and puts the offsets in where they are put in there."""
    lines = []
    for line in script.split("\n"):
        if line.startswith("$"):
            major, minor = (int(n) for n in line[1:5].strip().split("."))
            if version[:2] < (major, minor):
                continue
            line = "     " + line[5:] if line[4] != " " else "    " + line[4:]
        lines.append(line)
    text = "\n".join(lines)
    for mark in ("# int register offset\n", "# float register offset\n"):
        text = text.replace(mark, mark + str(offset))
    return text


class Control:
    def __init__(self, ports, offset):
        self.offset = offset
        self.rtde = Rtde(ports[0])
        assert self.rtde.ask("V", b"\x00\x02") == b"\x01"
        self.version = struct.unpack(">4I", self.rtde.ask("v"))
        self.rate = 125.0 if self.version[0] < 5 else 500.0
        ints = ["output_int_register_%d" % (offset + i) for i in range(3)]
        doubles = ["output_double_register_%d" % (offset + i) for i in range(6)]
        names = ["robot_status_bits", "safety_status_bits", "runtime_state"] + ints + doubles
        _, self.outputs = self.rtde.recipe("O", names, struct.pack(">d", self.rate), ",")
        self.inputs = []
        for number, (i, d, others) in enumerate(RECIPES, 1):
            names = ["input_int_register_%d" % offset] + ["input_double_register_%d" % (offset + k) for k in range(d)]
            names += ["input_int_register_%d" % (offset + k) for k in range(1, i)] + others
            got, form = self.rtde.recipe("I", names, end=",")
            assert got == number, "recipes are counted from 1"
            self.inputs.append(form)
        self.rtde.send("S")
        assert self.next_kind() == "S", "the answer to S comes before any data"
        self.send(4, 0)
        self.script = socket.create_connection((HOST, ports[1]), 10)

    def next_kind(self):
        while len(self.rtde.buffer) < 3:
            self.rtde.buffer += self.rtde.socket.recv(4096)
        kind = chr(self.rtde.buffer[2])
        self.rtde.receive(kind)
        return kind

    def state(self):
        values = struct.unpack(self.outputs, self.rtde.newest("U")[1:])
        return {"bits": values[0], "safety": values[1], "runtime": values[2], "ready": values[3], "double": values[6:]}

    def send(self, recipe, *values):
        self.rtde.send("U", bytes([recipe]) + struct.pack(self.inputs[recipe - 1], *values))

    def wait(self, good, what):
        end = time.time() + 15
        while time.time() < end:
            state = self.state()
            assert not state["safety"] & 4, "protective stop"
            if good(state):
                return state
        raise AssertionError("no " + what)

    def upload(self, text):
        self.script.sendall(text.encode())
        self.wait(lambda s: s["bits"] & 2, "running program")

    def stop_script(self):
        self.wait(lambda s: s["ready"] == 1, "ready script")
        self.send(4, 255)
        self.wait(lambda s: not s["bits"] & 2, "end of the script")
        self.send(4, 0)

    def command(self, recipe, number, *values):
        self.wait(lambda s: s["ready"] == 1, "ready script")
        self.send(recipe, number, *values)
        self.wait(lambda s: s["ready"] == 2, "done command %d" % number)
        self.send(4, 0)
        self.wait(lambda s: s["ready"] == 1, "ready script")


def main():
    ports = [int(p) for p in sys.argv[1:4]]
    dashboard = Dashboard(ports[2])
    polyscope = dashboard.ask("PolyscopeVersion")
    assert polyscope.startswith("URSoftware ") and polyscope.split()[1].count(".") == 3, polyscope
    if int(polyscope[11]) >= 5:
        assert dashboard.ask("get serial number").isdigit()
        assert dashboard.ask("is in remote control") == "true"
    for offset in (0, 24):
        run(ports, dashboard, offset)


def run(ports, dashboard, offset):
    watcher = Rtde(ports[0])
    watcher.ask("V", b"\x00\x02")
    names = ["timestamp", "actual_q", "target_q", "actual_digital_output_bits", "target_speed_fraction", "joint_mode"]
    _, form = watcher.recipe("O", names, struct.pack(">d", 25.0), ",")
    assert watcher.ask("S") == b"\x01"

    def see():
        values = struct.unpack(form, watcher.newest("U")[1:])
        return {"q": list(values[1:7]), "bits": values[13], "speed": values[14]}

    control = Control(ports, offset)
    text = fit(SCRIPT, control.version, offset)
    control.upload(text)
    q = see()["q"]
    goal = [q[0] + 0.15] + q[1:]
    control.command(1, 1, *goal, 0.9, 1.4, 0)
    assert max(abs(a - b) for a, b in zip(see()["q"], goal)) < 1e-3
    for k in range(100):  # servoJ: no answer is waited for, the host keeps the time
        goal[0] -= 0.001
        control.send(2, 11, *goal, 0.0, 0.0, 0.008, 0.1, 300.0)
        control.state()
    control.command(8, 16, 10.0)
    assert abs(see()["q"][0] - goal[0]) < 0.05
    control.command(19, 57, *[0.0] * 7, 0)

    # A path is put into the script, which is then sent anew while it runs.
    control.stop_script()
    q = see()["q"]
    moves = "".join("\tmovej([%s],a=1.4,v=1,r=0)\n" % ",".join("%.6f" % v for v in [q[0] + d] + q[1:]) for d in (0.1, 0))
    control.upload(text.replace("# inject path\n", "# inject path\n" + moves))
    control.command(15, 45, 0)

    # The other interface: digital outputs and the speed slider, on a link that sets up no outputs.
    io = Rtde(ports[0])
    io.ask("V", b"\x00\x02")
    command = "input_int_register_%d" % (offset + 23)
    forms = [io.recipe("I", [command] + more, end=",")[1] for more in (
        [], ["standard_digital_output_mask", "standard_digital_output"],
        ["tool_digital_output_mask", "tool_digital_output"], ["speed_slider_mask", "speed_slider_fraction"])]
    io.send("U", b"\x02" + struct.pack(forms[1], 0, 8, 8))
    io.send("U", b"\x04" + struct.pack(forms[3], 0, 1, 0.5))
    end = time.time() + 5
    while time.time() < end and not (see()["bits"] & 8 and see()["speed"] == 0.5):
        pass
    assert see()["bits"] & 8 and see()["speed"] == 0.5
    io.send("U", b"\x02" + struct.pack(forms[1], 0, 8, 0))
    io.send("U", b"\x04" + struct.pack(forms[3], 0, 1, 1.0))

    # Another program of the same user while one runs: it is ended first, by its own command and by the Dashboard.
    control.stop_script()
    assert dashboard.ask("stop") == "Stopped"
    watcher.socket.close()
    io.socket.close()
    control.rtde.socket.close()
    time.sleep(0.1)


if __name__ == "__main__":
    main()
