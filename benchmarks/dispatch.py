"""Engine time per action over real Socket.IO, with journal and ledger on disk.

A device that does nothing is asked N times by a protocol. Beside it, in the same run: a bare
`sio.call` to the same server, and an fsync of a line as long as a journal record.
Run: python benchmarks/dispatch.py [--goals N]
"""

import argparse
import asyncio
import itertools
import os
import statistics
import tempfile
import time
from pathlib import Path

CONTRACT = """
type: nothing@1
summary: Does nothing, at once
actions:
  nothing: {effect: once, duration: 1 ms, params: {type: object, properties: {i: {type: integer}}}}
"""
DRIVER = '''
from labrun.drivers.driver import Driver


class Nothing(Driver):
    """Does nothing."""

    contract = "nothing@1"

    async def nothing(self, goal, *, i=0):
        return {}
'''
LAB = """
name: bench
contracts: [./nothing.yaml]
devices:
  nothing: {contract: nothing@1, driver: "./nothing.py:Nothing"}
"""
PROTOCOL = """
labrun: 1
name: dispatch
devices: {{nothing: nothing@1}}
steps:
  - foreach: {{i: "${{{{ range({count}) }}}}"}}
    steps:
      - {{do: nothing.nothing, with: {{i: "${{{{ i }}}}"}}}}
"""
PAPER_S_A_POINT = 15.0
ACTIONS_A_POINT = 6


def engine_times(folder: Path, count: int) -> tuple[list[float], list[float]]:
    """Seconds from goal to goal, and from a result to the next goal, through the whole engine."""
    from labrun.drivers.client.client import DeviceClient
    from labrun.engine.check import check_file
    from labrun.engine.commands.run import start

    sent: list[float] = []
    ended: list[float] = []
    follow = DeviceClient.follow

    async def timed(self, goal, *more, **named):
        sent.append(time.perf_counter())
        outcome = await follow(self, goal, *more, **named)
        ended.append(time.perf_counter())
        return outcome

    path = folder / "dispatch.yaml"
    path.write_text(PROTOCOL.format(count=count), encoding="utf-8")
    checked = check_file(path, lab=folder / "lab.yaml")
    assert checked.ok, checked.problems
    DeviceClient.follow = timed
    try:
        assert start(checked, folder / "runs") == 0
    finally:
        DeviceClient.follow = follow
    whole = [b - a for a, b in itertools.pairwise(sent)]
    between = [b - a for a, b in zip(ended, sent[1:], strict=False)]
    return whole, between


async def bare_calls(folder: Path, count: int) -> list[float]:
    """Seconds of a bare `sio.call` that the same server answers at once."""
    import socketio

    from labrun.drivers.client.launch import start_server
    from labrun.engine.dispatch.connect import server_config
    from labrun.engine.lab.lab import load_lab

    lab, problems = load_lab(folder / "lab.yaml")
    assert lab is not None, problems
    config = server_config(lab.lab.devices, lab, folder / "bare")
    server = await start_server({**config, "port": 0, "own_token": False}, folder / "bare")
    client = socketio.AsyncClient(handle_sigint=False)
    times = []
    try:
        await client.connect(server.url, transports=["websocket"], namespaces=["/action"])
        for _ in range(count):
            began = time.perf_counter()
            await client.call("query", {"ids": []}, namespace="/action", timeout=5)
            times.append(time.perf_counter() - began)
    finally:
        await client.disconnect()
        await server.stop()
    return times


def fsyncs(folder: Path, count: int) -> list[float]:
    """Seconds to append a line of 400 bytes and make it durable."""
    times = []
    with (folder / "line").open("ab", buffering=0) as file:
        for _ in range(count):
            began = time.perf_counter()
            file.write(b"x" * 400)
            os.fdatasync(file.fileno())
            times.append(time.perf_counter() - began)
    return times


def main() -> None:
    """Print medians, and their ratios to the baselines."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--goals", type=int, default=2000)
    count = parser.parse_args().goals
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in (("nothing.yaml", CONTRACT), ("nothing.py", DRIVER), ("lab.yaml", LAB)):
            (folder / file).write_text(text, encoding="utf-8")
        whole, between = engine_times(folder, count)
        bare = asyncio.run(bare_calls(folder, count))
        sync = fsyncs(folder, count)
    action, gap, call, fsync = (1000 * statistics.median(t) for t in (whole, between, bare, sync))
    print(f"{count} actions of a device that does nothing, journal and ledger on disk; medians")
    print(f"  engine, per action              {action:7.3f} ms")
    print(f"  from a result to the next goal  {gap:7.3f} ms")
    print(f"  bare sio.call                   {call:7.3f} ms")
    print(f"  fsync of a record               {fsync:7.3f} ms")
    print(f"  engine / bare call              {action / call:7.1f}")
    print(f"  engine / (bare call + 3 fsyncs) {action / (call + 3 * fsync):7.1f}")
    share = 100 * ACTIONS_A_POINT * action / 1000 / PAPER_S_A_POINT
    print(f"  share of the paper's {PAPER_S_A_POINT:g} s a point {share:5.2f} %")


if __name__ == "__main__":
    main()
