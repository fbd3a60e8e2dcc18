"""What the GRBL driver adds to a move: its moves beside a bare pyserial loop that writes the same bytes.

The loop waits for the answer to each write as the driver does, and judges nothing. By turns, in one run,
on the emulated controller of the tests, or on a real one with `--port` (it is homed, and moves within
10 mm of its zero). Printed: the median move in milliseconds, and the ratio of the medians.
Run: python benchmarks/moves.py [--moves N] [--rounds N] [--port PORT]
"""

import argparse
import asyncio
import statistics
import sys
import tempfile
import time
from pathlib import Path

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.grbl.gantry import Grbl
from labrun.drivers.motion.bench import LETTERS

sys.path.insert(0, str(Path(__file__).parents[1]))
STEP_MM = 0.2


async def driven(driver: Grbl, moves: int) -> tuple[list[float], list[list[bytes]]]:
    """Seconds of each of so many short moves, and what was written for it."""
    written: list[bytes] = []
    write = driver.controller.port.write

    def note(data: bytes) -> None:
        written.append(data)
        write(data)

    driver.controller.port.write = note  # type: ignore[method-assign]
    took: list[float] = []
    each: list[list[bytes]] = []
    for number in range(moves):
        begun = time.perf_counter()
        await driver.move_to(GoalContext(f"m{number}"), x=1 + STEP_MM * (number % 2))
        took.append(time.perf_counter() - begun)
        each.append(written.copy())
        written.clear()
    driver.controller.port.write = write  # type: ignore[method-assign]
    return took, each


def bare(serial, written: list[bytes]) -> float:
    """Seconds for the same bytes, one after the other, each with its answer."""
    begun = time.perf_counter()
    rest = b""
    for data in written:
        serial.write(data)
        wanted = b"<" if data == b"?" else b"ok"
        answered = False
        while not answered:  # all that is there: pyserial's `readline` takes byte by byte
            *lines, rest = (rest + serial.read(max(1, serial.in_waiting))).split(b"\n")
            answered = any(line.startswith(wanted) for line in lines)
    return time.perf_counter() - begun


async def main(moves: int, rounds: int, port: str) -> None:
    """By turns, and print."""
    from serial import Serial

    times: dict[str, list[float]] = {"driver": [], "bare loop": []}
    with tempfile.TemporaryDirectory() as folder:
        place = Place("gantry", {"port": port}, {}, Path(folder), Path(folder))
        for _ in range(rounds):
            driver = Grbl(place)
            await driver.open()
            await driver.home(GoalContext("home"))
            await driver.move_to(GoalContext("begin"), x=1)
            letter, begin = driver.bench.to_machine(0, 1.0)
            took, written = await driven(driver, moves)
            times["driver"] += took
            await driver.close()
            with Serial(port, 115200, timeout=5) as serial:
                serial.timeout = 120
                serial.read_until(b"Grbl")  # it boots, and loses what is sent before
                await asyncio.sleep(0.5)
                serial.read(serial.in_waiting)
                serial.write(b"$H\n")
                serial.read_until(b"ok")
                line = f"G21G90G94G53G0{LETTERS[letter]}{begin:.4f}\n"
                bare(serial, [line.encode(), b"G4P0\n"])
                times["bare loop"] += [bare(serial, one) for one in written]
    for name, found in times.items():
        print(f"{name:<10} {1e3 * statistics.median(found):8.2f} ms a move")
    driver_s, bare_s = (statistics.median(found) for found in times.values())
    print(f"ratio      {driver_s / bare_s:8.2f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moves", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--port")
    given = parser.parse_args()
    if given.port:
        asyncio.run(main(given.moves, given.rounds, given.port))
    else:
        from tests.drivers.grbl.peer import Peer

        peer = Peer(speed=20.0)
        try:
            asyncio.run(main(given.moves, given.rounds, peer.path))
        finally:
            peer.close()
