#!/usr/bin/python3
"""A PLC (pymodbus client) that names a part, and takes it away after its first defect.

usage: plc_that_changes_parts.py PORT: prints NAMED, DEFECT serial and GONE as the station acknowledges each
"""
import logging
import sys
import time

from pymodbus.client import ModbusTcpClient


def words(content, registers):
    padded = content.encode("ascii").ljust(2 * registers, b"\0")
    return [int.from_bytes(padded[i:i + 2], "big") for i in range(0, 2 * registers, 2)]


def until(condition):
    deadline = time.monotonic() + 120
    while True:
        station = client.read_input_registers(0, 34, slave=1).registers
        if condition(station):
            return station
        if time.monotonic() > deadline:
            sys.exit("the station did not answer in time")
        time.sleep(0.02)


logging.disable()  # a station that does not listen yet is no trouble
client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
deadline = time.monotonic() + 60
while not client.connect():
    if time.monotonic() > deadline:
        sys.exit("nobody listens")
    time.sleep(0.05)
client.write_registers(3, words("bumper-front-x", 16) + words("SN-0042", 16), slave=1)
client.write_register(2, 7, slave=1)
until(lambda r: r[3] == 7)
print("NAMED", flush=True)
defect = until(lambda r: r[6] != 0 and r[4] != 0)
serial = b"".join(r.to_bytes(2, "big") for r in defect[18:34]).split(b"\0")[0].decode("ascii")
print("DEFECT", serial, "count", defect[4], flush=True)
client.write_registers(1, [defect[6], 0], slave=1)
gone = until(lambda r: r[3] == 0)
print("GONE count", gone[4], flush=True)
