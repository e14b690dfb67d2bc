#!/usr/bin/python3
"""A PLC as Modbus server (pymodbus): holds 200 registers, beats its heart, names a part, echoes defects.

usage: plc_that_answers.py PORT [--no-echo] [--registers N]
prints LISTENING, then DEFECT id sequence for each new one, STATUS word at each change of the status word
"""
import argparse
import asyncio

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import StartAsyncTcpServer


def words(content, registers):
    padded = content.encode("ascii").ljust(2 * registers, b"\0")
    return [int.from_bytes(padded[i:i + 2], "big") for i in range(0, 2 * registers, 2)]


async def live(store, echo):
    heartbeat, last, status = 0, 0, 0
    store.setValues(3, 3, words("bumper-front-a", 16) + words("SN-0042", 16))
    store.setValues(3, 2, [7])
    print("LISTENING", flush=True)
    while True:
        heartbeat = (heartbeat + 1) % 65536
        store.setValues(3, 0, [heartbeat])
        r = store.getValues(3, 100, 34)
        if r[0] != status:
            status = r[0]
            print("STATUS", status, flush=True)
        if r[6] not in (0, last):
            last = r[6]
            print("DEFECT", r[7] << 16 | r[8], r[6], flush=True)
            if echo:
                store.setValues(3, 1, [last])
        await asyncio.sleep(0.005)


async def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("port", type=int)
    parser.add_argument("--no-echo", action="store_true")
    parser.add_argument("--registers", type=int, default=200)
    options = parser.parse_args()
    block = ModbusSequentialDataBlock(0, [0] * options.registers)
    store = ModbusSlaveContext(hr=block, zero_mode=True)
    if options.registers >= 200:
        asyncio.get_running_loop().create_task(live(store, not options.no_echo))
    else:
        print("LISTENING", flush=True)
    await StartAsyncTcpServer(context=ModbusServerContext(slaves=store, single=True), address=("127.0.0.1", options.port))


asyncio.run(main())
