#!/usr/bin/python3
"""A PLC as Modbus client (pymodbus): asks the station in a cycle, beats its heart, names a part, echoes defects.

usage: plc_that_asks.py PORT DEFECTS: ends after so many defects, printing DEFECT id sequence x y z zone arm serial
"""
import sys
import time

from pymodbus.client import ModbusTcpClient


def signed(high, low):
    value = high << 16 | low
    return value - (1 << 32) if value >= 1 << 31 else value


def text(registers):
    return b"".join(r.to_bytes(2, "big") for r in registers).split(b"\0")[0].decode("ascii")


def words(content, registers):
    padded = content.encode("ascii").ljust(2 * registers, b"\0")
    return [int.from_bytes(padded[i:i + 2], "big") for i in range(0, 2 * registers, 2)]


client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
assert client.connect()
assert not client.write_registers(3, words("bumper-front-a", 16) + words("SN-0042", 16), slave=1).isError()
assert not client.write_register(2, 7, slave=1).isError()
heartbeat, last, seen = 0, 0, 0
while seen < int(sys.argv[2]):
    heartbeat = (heartbeat + 1) % 65536
    assert not client.write_registers(0, [heartbeat, last], slave=1).isError()
    r = client.read_input_registers(0, 34, slave=1).registers
    assert r[2] == 1, "map version"
    if r[6] not in (0, last):
        last = r[6]
        seen += 1
        print("DEFECT", r[7] << 16 | r[8], r[6], signed(r[9], r[10]), signed(r[11], r[12]), signed(r[13], r[14]),
              r[15], r[16], text(r[18:34]), flush=True)
    time.sleep(0.005)
client.write_registers(0, [heartbeat + 1, last], slave=1)
r = client.read_input_registers(0, 34, slave=1).registers
print("DONE", "taken", r[3], "waiting", r[5], "status", r[0] & 0x1FF, flush=True)
