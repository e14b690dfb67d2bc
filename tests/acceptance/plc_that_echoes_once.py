#!/usr/bin/python3
"""A PLC (pymodbus client) that takes one defect and falls asleep.

usage: plc_that_echoes_once.py PORT: prints the defect's id
"""
import logging
import sys
import time

from pymodbus.client import ModbusTcpClient

logging.disable()  # a station that does not listen yet is no trouble
client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
deadline = time.monotonic() + 60
while not client.connect():
    if time.monotonic() > deadline:
        sys.exit("nobody listens")
    time.sleep(0.05)
client.write_registers(0, [1, 0], slave=1)  # the first word is never an echo
while True:
    station = client.read_input_registers(0, 34, slave=1).registers
    if station[6] != 0:
        break
    time.sleep(0.02)
client.write_registers(0, [2, station[6]], slave=1)
while client.read_input_registers(0, 34, slave=1).registers[6] == station[6]:
    time.sleep(0.02)
print(station[7] << 16 | station[8])
