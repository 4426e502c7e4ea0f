#!/usr/bin/env python3
"""pymodbus as it comes from Debian, asked as Robotiq's ROS nodes ask: whole 16-byte commands from register 0 and status
by input registers over TCP, without a unit; registers 1000 and 2000 of unit 9 over the serial line.

peer_pymodbus.py TCP_PORT SERIAL_LINE: exits 0 when the gripper behaves.
"""
import sys
import time

from pymodbus.client import ModbusSerialClient, ModbusTcpClient


class Tcp:
    def __init__(self, port):
        self.client = ModbusTcpClient("127.0.0.1", port=port)
        assert self.client.connect()

    def send(self, words):
        return self.client.write_registers(0, words)

    def ask(self, count):
        return self.client.read_input_registers(0, count)


class Serial:
    def __init__(self, line):
        self.client = ModbusSerialClient(line, baudrate=115200, bytesize=8, parity="N", stopbits=1, timeout=1.0)
        assert self.client.connect()

    def send(self, words):
        return self.client.write_registers(0x03E8, words, slave=9)

    def ask(self, count):
        return self.client.read_holding_registers(0x07D0, count, slave=9)


def drive(wire):
    def command(byte_0, position=0, speed=0, force=0):
        data = [byte_0, 0, 0, position, speed, force] + [0] * 10
        reply = wire.send([256 * a + b for a, b in zip(data[::2], data[1::2])])
        assert not reply.isError() and reply.count == 8, reply

    def status():
        reply = wire.ask(8)
        assert not reply.isError() and len(reply.registers) == 8, reply
        return [byte for word in reply.registers for byte in (word >> 8, word & 0xFF)]

    def until(good, what):
        end = time.time() + 15
        while time.time() < end:
            now = status()
            if good(now):
                return now
        raise AssertionError("no %s, last %s" % (what, now))

    command(0)
    until(lambda s: s[0] == 0, "reset")
    command(0x01)
    until(lambda s: s[0] == 0x31, "activation")
    command(0x09, 255, 255, 150)
    closed = until(lambda s: s[3] == 255 and s[0] >> 6 == 3, "closed hand")
    assert closed[1] == 0xFF and closed[2] == 0 and closed[4] > 230, closed
    command(0x09, 0, 255, 150)
    opened = until(lambda s: s[3] == 0 and s[0] >> 6 == 3, "open hand")
    assert opened[4] < 10, opened
    command(0x03)
    until(lambda s: s[0] & 0x37 == 0x33, "pinch mode")
    command(0x01)
    until(lambda s: s[0] & 0x37 == 0x31, "basic mode")
    wire.client.close()


if __name__ == "__main__":
    drive(Tcp(int(sys.argv[1])))
    drive(Serial(sys.argv[2]))
