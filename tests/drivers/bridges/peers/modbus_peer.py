"""A furnace as pymodbus serves it, in a process of its own; what it does is in FOLDER/done.jsonl.

Holding 10: set point in 0.1 degC; 20-21: float32; coil 0: dose (one dose each time it is set).
Input 0: temperature, int16, 0.1 degC; 1: doses; 2: busy; 4-5: NaN; 6-7: 1.5 as float32, each pair of bytes
and of words turned round; 8-9: OVEN. Discrete 0: door. It may be too busy to answer (`rude`).
"""

import asyncio
import json
import struct
import sys
from pathlib import Path

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
NAN = struct.unpack(">HH", struct.pack(">f", float("nan")))
state = {"doses": 0, "busy": 0}


def done(what, **more):
    with (folder / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


async def act(function, start, address, count, registers, values):
    """Called for every request: 5 sets a coil, 6 and 16 write registers, 4 reads inputs."""
    if function == 4:
        registers[:6] = [2153, state["doses"], state["busy"], 0, *NAN]
        registers[6:10] = [0x0000, 0xC03F, 0x4F56, 0x454E]
        return ExcCodes.DEVICE_BUSY if state["busy"] and habits.get("rude") else None
    if function in (5, 6) and habits.get("several"):
        return ExcCodes.ILLEGAL_FUNCTION
    if function == 5 and values and values[0]:
        state["busy"] = 1
        asyncio.get_running_loop().call_later(habits.get("work_s", 0.1), dosed)
    elif function in (6, 16) and values is not None:
        done("write", address=address, values=list(values))
    return None


def dosed():
    state["doses"] += 1
    state["busy"] = 0
    done("dispense")


async def main():
    bits, words = DataType.BITS, DataType.REGISTERS
    tables = (
        [SimData(0, values=[False] * 16, datatype=bits)],
        [SimData(0, values=[True] * 16, datatype=bits)],
        [SimData(0, values=[0] * 40, datatype=words)],
        [SimData(0, values=[0] * 10, datatype=words)],
    )
    server = ModbusTcpServer(SimDevice(1, tables, action=act), address=("127.0.0.1", 0))
    serving = asyncio.get_running_loop().create_task(server.serve_forever())
    while not server.transport:  # noqa: ASYNC110 - the library has no event for it
        await asyncio.sleep(0.01)
    done("on")
    (folder / "where.part").write_text(f"127.0.0.1:{server.transport.sockets[0].getsockname()[1]}")
    (folder / "where.part").replace(folder / "where")
    await serving


asyncio.run(main())
