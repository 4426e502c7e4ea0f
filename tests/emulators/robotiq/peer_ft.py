#!/usr/bin/env python3
"""A force sensor on its serial line as Robotiq's own driver finds it: the line's settings, the order of the steps and
the patience between them are that driver's; the code is ours. Standard library only.

peer_ft.py SERIAL_LINE FZ: exits 0 when the sensor behaves and presses with FZ newton.
"""
import os
import struct
import sys
import termios
import time

LOOK = 0.004  # s between looks at the line
QUIET = 20  # looks without a byte: no stream


def crc(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ 0xA001 if value & 1 else value >> 1
    return struct.pack("<H", value)


class Sensor:
    def __init__(self, line):
        self.file = os.open(line, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_EXCL)
        modes = termios.tcgetattr(self.file)
        modes[4] = modes[5] = termios.B19200
        modes[2] = modes[2] & ~(termios.CSIZE | termios.CSTOPB | termios.PARENB) | termios.CLOCAL | termios.CREAD | termios.CS8
        modes[3] &= ~(termios.ICANON | termios.ECHO | termios.ECHOE | termios.ISIG)
        modes[0] &= ~(termios.ICRNL | termios.INPCK | termios.IXON | termios.IXOFF | termios.IXANY)
        modes[6][termios.VMIN], modes[6][termios.VTIME] = 0, 1
        termios.tcsetattr(self.file, termios.TCSANOW, modes)

    def read(self):
        time.sleep(LOOK)
        try:
            return os.read(self.file, 1024)
        except BlockingIOError:
            return b""

    def streams(self, looks):
        return any([self.read() for _ in range(looks)])

    def ask(self, first, count):
        """The only frame that comes is the reply: whatever else stands before it would spoil its checksum."""
        request = struct.pack(">BBHH", 9, 3, first, count)
        os.write(self.file, request + crc(request))
        reply = b""
        for _ in range(100):
            reply += self.read()
            if len(reply) >= 5 + 2 * count:
                break
        assert reply[:3] == bytes([9, 3, 2 * count]) and crc(reply[:-2]) == reply[-2:], (first, reply)
        return struct.unpack(">%dH" % count, reply[3:-2])


def main():
    sensor = Sensor(sys.argv[1])
    if sensor.streams(QUIET):
        os.write(sensor.file, b"\xff" * 50)
        deadline = time.time() + 10
        while sensor.streams(QUIET):
            assert time.time() < deadline, "the stream does not stop"
    time.sleep(0.1)
    assert sensor.ask(500, 1)[0] >> 8 == ord("F"), "a sensor"
    version = sensor.ask(500, 3)
    assert bytes([version[0] >> 8, version[0] & 255, version[1] >> 8]) == b"FTS", version
    year, serial = sensor.ask(514, 1), sensor.ask(510, 4)
    assert 2010 < year[0] < 2030 and serial[2] + 65536 * serial[3] > 0, (year, serial)

    request = struct.pack(">BBHHBH", 9, 16, 410, 1, 2, 0x0200)
    os.write(sensor.file, request + crc(request))
    seen = b""
    while len(seen) < 8 + 20 * 16:
        seen += sensor.read()
    echo = struct.pack(">BBHH", 9, 16, 410, 1)
    assert seen[:8] == echo + crc(echo), "the echo comes before the first frame"
    frames = seen[8:]
    for at in range(0, 20 * 16, 16):
        frame = frames[at:at + 16]
        assert frame[:2] == b"\x20\x4e" and crc(frame[:14]) == frame[14:], frame
        force_z = struct.unpack("<6h", frame[2:14])[2] / 100.0
        assert abs(force_z - float(sys.argv[2])) < 0.5, force_z
    os.close(sensor.file)


if __name__ == "__main__":
    main()
