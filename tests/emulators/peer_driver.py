#!/usr/bin/env python3
"""A driver that reads the primary port, keeps RTDE for state and has the robot dial back for its commands: the order of
its questions and what it reads out of every package are those of UR's own C++ client library; the code and the script
are ours. Standard library only.

peer_driver.py RTDE_PORT PRIMARY_PORT DASHBOARD_PORT: exits 0 when the robot behaves.
"""
import re
import socket
import struct
import sys
import time

from peer_control import Dashboard
from peer_rtde import HOST, Rtde

SCALE = 1000000


class Primary:
    """Packages of the primary port, the fields taken one by one until none is left."""

    def __init__(self, port):
        self.socket = socket.create_connection((HOST, port), 10)
        self.file = self.socket.makefile("rb")

    def package(self):
        size = struct.unpack(">i", self.file.read(4))[0]
        body = self.file.read(size - 4)
        return body[0], body[1:]

    def message(self, kind, seconds=5.0):
        end = time.time() + seconds
        while time.time() < end:
            package, body = self.package()
            if package == 20 and body[9] == kind:
                return body[10:]
        raise AssertionError("no message of kind %d" % kind)

    def key(self, title):
        while True:
            body = self.message(7)
            length = body[8]
            if body[9:9 + length].decode() == title:
                return body[9 + length:].decode()

    def state(self):
        while True:
            package, body = self.package()
            if package == 16:
                break
        parts = {}
        while body:
            size, kind = struct.unpack(">iB", body[:5])
            assert size >= 5
            parts[kind], body = body[5:size], body[size:]
        return parts


def check_state(parts, version):
    newer = version >= (3, 10) if version[0] < 5 else version >= (5, 4)
    mode = struct.unpack(">Q7?BBddd", parts[0][:41])
    assert mode[1] and mode[2] and mode[8] == 7, mode
    assert len(parts[0]) == 41 + newer
    joints = struct.unpack(">" + "dddffffB" * 6, parts[1])
    assert all(m == 253 for m in joints[7::8]), "joints run"
    assert len(parts[4]) == 12 * 8 and len(parts[7]) == 7 * 8
    kinematics = struct.unpack(">6I24dI", parts[5])
    theta, a, d, alpha = (kinematics[6 + 6 * k:12 + 6 * k] for k in range(4))
    assert abs(a[1] + 0.612) < 1e-3 and abs(a[2] + 0.5723) < 1e-3 and abs(d[0] - 0.1273) < 1e-3, (a, d)
    assert abs(alpha[0] - 1.570796) < 1e-5 and not any(theta)
    board = struct.unpack(">II??ddBBddffffBBBIBB", parts[3][:69])
    assert board[14] == 1 and board[16] == 0 and len(parts[3]) == 69 + newer, board
    limits = struct.unpack(">24d5d24d4I", parts[6][:440])
    assert limits[0] < -6 and limits[1] > 6 and limits[-2] == 2, "a UR10"


def main():
    ports = [int(p) for p in sys.argv[1:4]]
    dashboard = Dashboard(ports[2])
    version = tuple(int(n) for n in re.match(r"URSoftware (\d+)\.(\d+)\.(\d+)", dashboard.ask("PolyscopeVersion")).groups())
    assert dashboard.ask("stop") == "Stopped", "stopping nothing is no error"
    assert re.fullmatch("STOPPED .*", dashboard.ask("programState"))

    def until(command, pattern):
        end = time.time() + 10
        while not re.fullmatch(pattern, dashboard.ask(command)):
            assert time.time() < end, command
            time.sleep(0.1)

    for order, answer, mode in (("power off", "Powering off", "POWER_OFF"), ("power on", "Powering on", "(IDLE|RUNNING)"),
                                ("brake release", "Brake releasing", "RUNNING")):
        assert dashboard.ask(order) == answer
        until("robotmode", "Robotmode: " + mode)

    primary = Primary(ports[1])
    first, body = primary.package()
    assert first == 20 and body[9] == 3, "the version comes first"
    name = body[11:11 + body[10]]
    major, minor = struct.unpack(">BB", body[11 + len(name):13 + len(name)])
    assert (major, minor) == version[:2]
    check_state(primary.state(), version)

    rtde = Rtde(ports[0])
    assert rtde.ask("V", b"\x00\x03") == b"\x00", "a version that it does not have is refused"
    assert rtde.ask("V", b"\x00\x02") == b"\x01"
    control = struct.unpack(">4I", rtde.ask("v"))
    rate = 125.0 if control[0] < 5 else 500.0
    wanted = ["actual_q", "actual_qd", "speed_scaling", "target_speed_fraction", "runtime_state", "robot_mode", "safety_mode",
              "robot_status_bits", "safety_status_bits", "actual_digital_input_bits", "tool_mode", "tool_output_voltage",
              "actual_TCP_force", "tcp_offset", "output_bit_registers0_to_31", "timestamp"]
    _, outputs = rtde.recipe("O", wanted, struct.pack(">d", rate))
    assert rtde.ask("S") == b"\x01"
    stamp = struct.unpack(">d", rtde.receive("U")[-8:])[0]
    assert stamp > 40, "booted long ago"
    assert rtde.ask("P") == b"\x01"
    rtde.recipe("I", ["speed_slider_mask", "speed_slider_fraction", "standard_digital_output_mask",
                      "standard_digital_output", "tool_digital_output_mask", "tool_digital_output"])
    assert rtde.ask("S") == b"\x01"

    def joints():
        return list(struct.unpack(outputs, rtde.newest("U")[1:])[:6])

    servers = [socket.create_server((HOST, 0)) for _ in range(3)]
    addresses = [s.getsockname()[1] for s in servers]
    script = """def driver():
  steptime = get_steptime()
  MULT = %d
  global mode = -1
  global goal = get_joint_positions()
  global read_timeout = 0.0 # the first read waits
  thread_move = 0
  def connected(host, port, name, max_attempts=5, dt=0.2):
    attempt = 0
    while attempt < max_attempts:
      if socket_open(host, port, name):
        return True
      end
      sleep(dt)
      attempt = attempt + 1
    end
    return False
  end
  thread servo():
    while mode == 1:
      enter_critical
      q = goal
      servoj(q, t=steptime, lookahead_time=0.03, gain=2000)
      exit_critical
    end
    stopj(4.0)
  end
  thread commands():
    while mode > -2:
      raw = socket_read_binary_integer(28, "script_command_socket", 0)
      if raw[0] > 0:
        if raw[1] == 0:
          zero_ftsensor()
        elif raw[1] == 1:
          set_payload(raw[2] / MULT, [raw[3] / MULT, raw[4] / MULT, raw[5] / MULT])
        end
      end
    end
  end
  thread trajectory():
    enter_critical
    raw = socket_read_binary_integer(19+1+1, "trajectory_socket", 0.5)
    if raw[0] > 0:
      q = [raw[1] / MULT, raw[2] / MULT, raw[3] / MULT, raw[4] / MULT, raw[5] / MULT, raw[6] / MULT]
      movej(q, a = raw[14] / MULT, v = raw[13] / MULT, t = raw[19] / 1000, r = raw[20] / 1000)
    end
    exit_critical
    stopj(4.0)
    socket_send_int(0, "trajectory_socket")
  end
  if not (connected("127.0.0.1", %d, "trajectory_socket") and connected("127.0.0.1", %d, "script_command_socket")
      and connected("127.0.0.1", %d, "reverse_socket")):
    popup("no connection", title="Error connecting to remote", blocking=True, error=True)
  end
  thread_commands = run commands()
  while mode > -2:
    enter_critical
    params = socket_read_binary_integer(8, "reverse_socket", read_timeout)
    if params[0] > 0:
      read_timeout = params[1] / 1000.0
      if mode != params[8]:
        mode = params[8]
        join thread_move
        if mode == 1:
          goal = get_joint_positions()
          thread_move = run servo()
        end
      end
      if mode == 1:
        goal = [params[2], params[3], params[4], params[5], params[6], params[7]] / MULT
      elif mode == 3 and params[2] == 1:
        thread_move = run trajectory()
      end
    else:
      textmsg("timed out")
      mode = -2
    end
    exit_critical
  end
  kill thread_commands
  join thread_move
  stopj(4.0)
  socket_close("reverse_socket")
end
""" % (SCALE, *addresses)
    primary.socket.sendall(script.encode())
    assert primary.key("PROGRAM_XXX_STARTED") == "driver"
    links = []
    for server in servers:
        server.settimeout(10)
        links.append(server.accept()[0])
    trajectory, commands, reverse = links

    def command(mode, numbers, timeout=500):
        reverse.sendall(struct.pack(">8i", timeout, *[int(round(n)) for n in numbers], mode))

    commands.sendall(struct.pack(">28i", 1, int(1.25 * SCALE), 0, 0, int(0.05 * SCALE), *[0] * 23))
    q = joints()
    for _ in range(100):
        q[0] += 0.0005
        command(1, [v * SCALE for v in q])
        joints()
    deadline = time.time() + 5
    while abs(joints()[0] - q[0]) > 5e-3 and time.time() < deadline:
        command(1, [v * SCALE for v in q])
    assert abs(joints()[0] - q[0]) < 5e-3
    goal = joints()
    goal[0] += 0.1
    point = [v * SCALE for v in goal] + [0] * 6 + [1.0 * SCALE, 1.4 * SCALE] + [0] * 4 + [0, 0, 0]
    trajectory.sendall(struct.pack(">21i", *[int(round(v)) for v in point]))
    command(3, [1, 1, 0, 0, 0, 0], 2000)
    trajectory.settimeout(10)
    answer = b""
    while len(answer) < 4:
        command(3, [0] * 6, 2000)
        trajectory.settimeout(0.05)
        try:
            answer += trajectory.recv(4 - len(answer))
        except socket.timeout:
            deadline -= 0.05
            assert deadline > time.time() - 20, "no end of the trajectory"
        joints()
    assert answer == b"\x00\x00\x00\x00"
    end = time.time() + 2
    while max(abs(a - b) for a, b in zip(joints(), goal)) > 2e-3 and time.time() < end:
        pass
    assert max(abs(a - b) for a, b in zip(joints(), goal)) < 2e-3
    command(-2, [0] * 6)
    assert primary.key("PROGRAM_XXX_STOPPED") == "driver"
    print("ok")


if __name__ == "__main__":
    main()
