#!/usr/bin/env python3
"""RTDE and script port as a stranger sees them: standard library only, written from the protocol's documentation.

peer_rtde.py RTDE_PORT PRIMARY_PORT: exits 0 when the robot behaves.
"""
import select
import socket
import struct
import sys
import time

HOST = "127.0.0.1"
FORMATS = {"DOUBLE": "d", "INT32": "i", "UINT32": "I", "UINT64": "Q", "UINT8": "B", "BOOL": "?",
           "VECTOR6D": "6d", "VECTOR3D": "3d", "VECTOR6INT32": "6i", "VECTOR6UINT32": "6I"}


class Rtde:
    def __init__(self, port):
        self.socket = socket.create_connection((HOST, port), 10)
        self.buffer = b""

    def send(self, kind, payload=b""):
        self.socket.sendall(struct.pack(">HB", len(payload) + 3, ord(kind)) + payload)

    def receive(self, kind):
        while True:
            while not self.is_whole():
                chunk = self.socket.recv(4096)
                assert chunk, "the link ended"
                self.buffer += chunk
            size = struct.unpack(">H", self.buffer[:2])[0]
            package, self.buffer = self.buffer[:size], self.buffer[size:]
            if chr(package[2]) == kind:
                return package[3:]

    def newest(self, kind):
        """Passes over all that have come but the last, as clients do that want the state of now."""
        package = self.receive(kind)
        while self.is_whole() or select.select([self.socket], [], [], 0)[0]:
            package = self.receive(kind)
        return package

    def is_whole(self):
        return len(self.buffer) >= 3 and len(self.buffer) >= struct.unpack(">H", self.buffer[:2])[0]

    def ask(self, kind, payload=b""):
        self.send(kind, payload)
        return self.receive(kind)

    def recipe(self, kind, names, prefix=b"", end=""):
        reply = self.ask(kind, prefix + (",".join(names) + end).encode())
        types = reply[1:].decode().split(",")
        assert reply[0] > 0 and len(types) == len(names), reply
        return reply[0], ">" + "".join(FORMATS[t] for t in types)


def main():
    rtde = Rtde(int(sys.argv[1]))
    assert rtde.ask("V", struct.pack(">H", 2)) == b"\x01"
    version = struct.unpack(">4I", rtde.ask("v"))
    assert version[0] in (3, 5), version
    names = ["timestamp", "actual_q", "actual_TCP_pose", "robot_mode", "runtime_state",
             "robot_status_bits", "output_int_register_24", "actual_digital_output_bits"]
    _, outputs = rtde.recipe("O", names, struct.pack(">d", 125.0))
    number, inputs = rtde.recipe("I", ["input_int_register_24", "input_double_register_24"])
    assert rtde.ask("S") == b"\x01"

    def state():
        package = rtde.receive("U")
        values = struct.unpack(outputs, package[1:])
        return {"time": values[0], "q": values[1:7], "pose": values[7:13], "mode": values[13],
                "runtime": values[14], "bits": values[15], "register": values[16]}

    first = state()
    assert first["mode"] == 7, first
    stamps = [first["time"]] + [state()["time"] for _ in range(20)]
    steps = [b - a for a, b in zip(stamps, stamps[1:])]
    assert all(abs(step - 0.008) < 1e-6 for step in steps), steps

    rtde.send("U", struct.pack(">B", number) + struct.pack(inputs, 41, 0.25))
    script = socket.create_connection((HOST, int(sys.argv[2])), 10)
    goal = list(first["q"])
    goal[0] += 0.2
    script.sendall(("def peer():\n"
                    "  write_output_integer_register(24, read_input_integer_register(24) + 1)\n"
                    "  movej(%s, a=1.4, v=1.0)\n"
                    "end\n" % goal).encode())
    deadline = time.time() + 20
    running = False
    while time.time() < deadline:
        now = state()
        running = running or now["bits"] & 2
        if running and not now["bits"] & 2:
            break
    assert now["register"] == 42, now
    assert max(abs(a - b) for a, b in zip(now["q"], goal)) < 1e-6, now

    intruder = Rtde(int(sys.argv[1]))
    intruder.ask("V", struct.pack(">H", 2))
    assert intruder.ask("I", b"input_int_register_24")[1:] == b"IN_USE"
    assert intruder.ask("S") == b"\x00", "started without outputs"
    assert rtde.ask("P") == b"\x01"


if __name__ == "__main__":
    main()
