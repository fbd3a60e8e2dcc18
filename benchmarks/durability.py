"""What durability costs an action, as ratios, and what an action costs beside two other libraries.

All in one run: the engine with the fsyncs of journal and ledger, without the journal's, without
any; a bare `sio.call` to the same server; one fsync; and, where they are installed, a bluesky
`grid_scan` over simulated devices and a DBOS workflow. docs/reference/figures.md says what each
line means. With `--against TREE`, another checkout, only the times beside that one's.
Run: python benchmarks/durability.py [--actions N] [--points N] [--peers PYTHON]
     python benchmarks/durability.py --against ../labrun-before [--rounds N]
"""

import argparse
import asyncio
import contextlib
import functools
import io
import os
import platform
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

from beside.against import BLOCKS, against
from beside.blocks import ACTIONS
from beside.disk import file_system, place_on_disk
from beside.peers import ask_peer
from beside.servers import serving
from beside.table import median_ms, show, show_bluesky, show_dbos, show_head, show_times
from beside.writes import writes_alone
from dispatch import ACTIONS_A_POINT, PAPER_S_A_POINT, engine_times, fsyncs

from labrun.schemas.messages import Goal

ROUNDS = 5
"""Every line is measured a fifth at a time, in turn, so that a slow moment affects all lines."""
WARM_UP = 20
"""What is left out at the start of each round."""
FSYNCS_AN_ACTION = 3

BARE, FSYNC = "bare sio.call", "one fsync of 400 bytes"
MESSAGES = "the 3 messages of an action, alone"
WRITES = "the 3 writes of an action, alone"
DURABLE = "engine, journal and ledger fsynced"
HALF = "engine, journal not fsynced"
NEITHER = "engine, neither fsynced"
LINES = (BARE, MESSAGES, FSYNC, WRITES, DURABLE, HALF, NEITHER)

Times = dict[str, list[float]]


def measure(folder: Path, actions: int) -> Times:
    """Seconds of every call, write and action, by line of the table."""
    synced, unsynced = folder / "synced", folder / "unsynced"
    count = -(-actions // ROUNDS)
    times: Times = defaultdict(list)
    with serving(synced, synced=True) as server, serving(unsynced, synced=False):
        engine(synced, WARM_UP)  # imports and first-time caches are not what is measured
        for n in range(ROUNDS):
            times[BARE] += asyncio.run(bare_calls(server.url, WARM_UP + count))[WARM_UP:]
            times[MESSAGES] += asyncio.run(exchanges(server.url, WARM_UP + count))[WARM_UP:]
            times[FSYNC] += fsyncs(folder, WARM_UP + count)[WARM_UP:]
            times[WRITES] += writes_alone(folder / f"writes{n}", WARM_UP + count)[WARM_UP:]
            times[DURABLE] += engine(synced, count)
            with forgetful_journal():
                times[HALF] += engine(synced, count)
                times[NEITHER] += engine(unsynced, count)
    return times


def engine(folder: Path, count: int) -> list[float]:
    """Seconds from goal to goal, on the server that this folder's lab names."""
    told = io.StringIO()
    try:
        with contextlib.redirect_stdout(told):
            whole, _ = engine_times(folder, WARM_UP + count + 1)
    except AssertionError as fault:
        raise SystemExit(f"the engine's run failed: {fault}\n{told.getvalue()[-500:]}") from fault
    return whole[WARM_UP:]


@contextlib.contextmanager
def forgetful_journal() -> Iterator[None]:
    """New runs write their journals and leave the rest to the system."""
    from labrun.engine.runner import begin

    unsynced = functools.partial(begin.Journal, sync=False)
    with mock.patch.object(begin, "Journal", unsynced):
        yield


async def bare_calls(url: str, count: int) -> list[float]:
    """Seconds of a `sio.call` that the server answers at once."""
    import socketio

    client = socketio.AsyncClient(handle_sigint=False)
    times = []
    try:
        await client.connect(url, transports=["websocket"], namespaces=["/action"])
        for _ in range(count):
            began = time.perf_counter()
            await client.call("query", {"ids": []}, namespace="/action", timeout=5)
            times.append(time.perf_counter() - began)
    finally:
        await client.disconnect()
    return times


async def exchanges(url: str, count: int) -> list[float]:
    """Seconds from a goal to its end as messages alone: sent, answered, told; nothing is done or kept."""
    import socketio

    client, told = socketio.AsyncClient(handle_sigint=False), asyncio.Event()
    client.on("update", lambda report: told.set(), namespace="/action")
    times = []
    try:
        await client.connect(url, transports=["websocket"], namespaces=["/action"])
        for i in range(count):
            goal = Goal(
                id=f"2026-01-01_dispatch_12345678/main/0/{i}/0/1", device="nothing",
                boot="123456789abc.12345678", epoch=i, action="nothing", params={"i": i},
                timeout_s=30.01,
            )  # fmt: skip
            told.clear()
            began = time.perf_counter()
            payload = goal.model_dump(exclude_defaults=True)
            await client.emit(
                "exchange", payload, namespace="/action", callback=lambda answer: None
            )
            await told.wait()
            times.append(time.perf_counter() - began)
    finally:
        await client.disconnect()
    return times


def show_ratios(ms: dict[str, float]) -> None:
    """The engine's lines beside each other and beside the baselines."""
    durable, neither = ms[DURABLE], ms[NEITHER]
    fsynced = ms[BARE] + FSYNCS_AN_ACTION * ms[FSYNC]
    print("ratios of the medians")
    show("durable / neither fsynced", durable / neither)
    show("durable / journal not fsynced", durable / ms[HALF])
    show("durable / bare call", durable / ms[BARE])
    show(f"durable / (bare call + {FSYNCS_AN_ACTION} fsyncs)", durable / fsynced)
    show("durable / (bare call + the 3 writes)", durable / (ms[BARE] + ms[WRITES]))
    show("neither fsynced / bare call", neither / ms[BARE])
    show("the 3 messages / bare call", ms[MESSAGES] / ms[BARE])
    show("(3 messages + 3 writes) / (bare call + 3 fsyncs)", (ms[MESSAGES] + ms[WRITES]) / fsynced)


def show_shares(ms: dict[str, float]) -> None:
    """What a point of the paper's scan would pay, in percent of its time."""
    percent_a_ms = 100 * ACTIONS_A_POINT / 1000 / PAPER_S_A_POINT
    print(
        f"percent of the paper's {PAPER_S_A_POINT:g} s a point, {ACTIONS_A_POINT} actions a point"
    )
    show("engine, durable", percent_a_ms * ms[DURABLE])
    show("durability alone", percent_a_ms * (ms[DURABLE] - ms[NEITHER]))


def show_against(other: Path, rounds: int) -> None:
    """The engine's times for an action beside those of another tree."""
    before, place = load(), place_on_disk()
    with tempfile.TemporaryDirectory(dir=place) as name:
        found = against(other, rounds, Path(name))
    print(
        f"{rounds} rounds of {BLOCKS} blocks of {ACTIONS} actions, {file_system(place)}; "
        f"load {before} before, {load()} after; medians of the blocks' ratios, each with its 95 % interval"
    )
    for line, (median, low, high) in found.items():
        show(line, median, f"{low:.3f} .. {high:.3f}")


def load() -> str:
    """How busy the machine was during the last minute."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--actions", type=int, default=1000, help="number of actions and of DBOS steps"
    )
    parser.add_argument("--points", type=int, default=500, help="points of bluesky's grid")
    parser.add_argument(
        "--peers", default=sys.executable, help="an interpreter with bluesky and DBOS"
    )
    parser.add_argument("--against", type=Path, metavar="TREE", help="another checkout of labrun")
    parser.add_argument("--rounds", type=int, default=4, help="rounds of --against")
    said = parser.parse_args()
    if said.against is not None:
        show_against(said.against, said.rounds)
        return
    if min(said.actions, said.points) < ROUNDS:
        parser.error(f"a median needs at least {ROUNDS} actions and points")
    before, place = load(), place_on_disk()
    with tempfile.TemporaryDirectory(dir=place) as name:
        times = measure(Path(name), said.actions)
        bluesky = ask_peer(said.peers, "bluesky_points.py", said.points)
        dbos = ask_peer(said.peers, "dbos_steps.py", said.actions, name)
    ms = {line: median_ms(times[line]) for line in LINES}
    print(
        f"{os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}, "
        f"{file_system(place)}; load {before} before, {load()} after"
    )
    print(f"{said.actions} actions, calls, writes and steps; {said.points} points")
    show_head()
    for line in LINES:
        show_times(line, times[line])
    show_ratios(ms)
    show_shares(ms)
    print("beside others")
    show_bluesky(bluesky, ms[DURABLE], ms[NEITHER])
    show_dbos(dbos, ms[DURABLE])


if __name__ == "__main__":
    main()
