"""Latency of the page: from a journal record to its patch, and answers with many numbers.

A real `labrun web` and a real run of 1,071 points (51 x 21) of a device that does nothing for a
while, about 50 journal records a second. Beside the answers, in the same run: the smallest one.
`--clients 20 --browser /usr/bin/chromium` has the run once more, watched by as many sockets and a
browser that shows its map, beside the one watched by a single socket.
Run: python benchmarks/page_server.py [--points N] [--clients N] [--browser PROGRAM]
"""

import argparse
import asyncio
import json
import os
import secrets
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

import httpx
import socketio

CONTRACT = """
type: nothing@1
summary: Does nothing, for 40 ms
actions:
  nothing: {effect: once, duration: 40 ms}
"""
DRIVER = '''
import asyncio

from labrun.drivers.driver import Driver


class Nothing(Driver):
    """Does nothing, for a while."""

    contract = "nothing@1"

    async def nothing(self, goal):
        await asyncio.sleep(0.04)
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
name: page
devices: {{nothing: nothing@1}}
steps:
  - id: scan
    foreach: {{p: "${{{{ grid(x=span(0, 50, 1), y=span(0, {rows}, 1)) }}}}"}}
    key: ${{{{ p.ix }}}},${{{{ p.iy }}}}
    steps: [{{do: nothing.nothing}}]
    collect: {{x: "${{{{ p.x }}}}", y: "${{{{ p.y }}}}", Li: "${{{{ p.index }}}}"}}
"""
MANY = """
labrun: 1
name: many
devices: {nothing: nothing@1}
steps:
  - {do: nothing.nothing}
  - {id: many, foreach: {i: "${{ range(100000) }}"}, steps: [{set: {n: "${{ i }}"}}]}
"""
CHANNELS = 22_800


class Page(httpx.Client):
    """A browser with control of the bench."""

    def start(self, protocol: str) -> str:
        """Start a protocol; the name of its run."""
        lease = self.post("/control/take", json={"name": "benchmark", "reason": "go"}).json()
        told = {
            "Idempotency-Key": secrets.token_hex(8), "X-Control-Lease": lease["lease"],
            "X-Deadline": str((time.time() + 30) * 1000),
        }  # fmt: skip
        launch = self.post("/runs", json={"protocol": protocol}, headers=told).json()
        while (run := self.get(f"/launches/{launch['id']}").json()["run"]) is None:
            time.sleep(0.05)
        return run

    def until_over(self, run: str) -> None:
        """Wait for the end of a run."""
        while self.get(f"/runs/{run}").json()["live"]:
            time.sleep(0.5)

    def took_ms(self, path: str, times: int = 15, **query: object) -> float:
        """Median of the times that an answer takes."""
        taken = []
        for _ in range(times):
            began = time.perf_counter()
            self.get(path, params=query).raise_for_status()
            taken.append(1000 * (time.perf_counter() - began))
        return statistics.median(taken)


async def watch(page: Page, run: str, clients: int) -> list[tuple[float, dict]]:
    """The patches of a run with the times at which they came to each client, until it is over."""
    came: list[tuple[float, dict]] = []
    cookie = "; ".join(f"{name}={value}" for name, value in page.cookies.items())
    sockets = [socketio.AsyncClient(request_timeout=60) for _ in range(clients)]
    for sio in sockets:
        sio.on("run_patch", lambda data: came.append((time.time(), data)), namespace="/ui")
        await sio.connect(
            str(page.base_url.copy_with(path="/")), headers={"Cookie": cookie},
            transports=["websocket"], namespaces=["/ui"], wait_timeout=60, retry=True,
        )  # fmt: skip
        await sio.call("watch", {"run": run}, namespace="/ui")
    await asyncio.to_thread(page.until_over, run)
    for sio in sockets:
        await sio.disconnect()
    return came


@contextmanager
def shown(browser: str | None, address: str) -> Iterator[None]:
    """While a browser without a window shows an address."""
    if browser is None:
        yield
        return
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        told = [browser, "--headless", "--no-sandbox", "--remote-debugging-port=0"]
        program = subprocess.Popen(
            [*told, f"--user-data-dir={profile}", address], stderr=subprocess.DEVNULL
        )
        try:
            yield
        finally:
            program.terminate()
            program.wait(timeout=30)


def scan(page: Page, runs: Path, pid: int, clients: int, browser: str | None) -> tuple[str, int]:
    """A run watched by so many; its name and how many points it had."""
    run, before = page.start("page.yaml"), cpu_s(pid)
    with shown(browser, str(page.base_url.copy_with(path=f"/runs/{run}"))):
        told, rate = delays_ms(runs / run / "journal.jsonl", asyncio.run(watch(page, run, clients)))
    print(
        f"{len(told) // clients:,} points at {rate:.0f} records/s, {clients} watching"
        f"{' beside a browser' if browser else ''}: record to patch {statistics.median(told):.0f} ms "
        f"median, {told[int(0.95 * len(told))]:.0f} ms at the 95th percentile; "
        f"{cpu_s(pid) - before:.1f} s of the server's processor time"
    )
    return run, len(told) // clients


def delays_ms(journal: Path, came: list[tuple[float, dict]]) -> tuple[list[float], float]:
    """From the record of each point's end to the patch that told it; and records a second."""
    records = [json.loads(line) for line in journal.read_text().splitlines()]
    at = [datetime.fromisoformat(record["at"]).timestamp() for record in records]
    ended = {r["key"]: t for r, t in zip(records, at, strict=True) if r["kind"] == "iteration"}
    told = [
        1000 * (when - ended[point["key"]])
        for when, patch in came
        for point in patch["points"]
        if point["status"] == "ok"
    ]
    return sorted(told), len(at) / (at[-1] - at[0])


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1071)
    parser.add_argument("--clients", type=int, default=1)
    parser.add_argument("--browser")
    given = parser.parse_args()
    rows = max(1, given.points // 51 - 1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "nothing.yaml").write_text(CONTRACT)
        (folder / "nothing.py").write_text(DRIVER)
        (folder / "lab.yaml").write_text(LAB)
        (folder / "shelf").mkdir()
        (folder / "shelf" / "page.yaml").write_text(PROTOCOL.format(rows=rows))
        (folder / "shelf" / "many.yaml").write_text(MANY)
        began = time.perf_counter()
        server = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", "web", str(folder / "shelf"), "--no-browser",
             "--lab", str(folder / "lab.yaml"), "--port", "0"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        try:
            assert server.stdout is not None
            url = server.stdout.readline().split()[-1]
            print(f"up after {time.perf_counter() - began:.2f} s")
            measure(url, folder / "shelf" / "runs", server.pid, given.clients, given.browser)
        finally:
            server.send_signal(signal.SIGTERM)
            server.wait(timeout=60)


def measure(url: str, runs: Path, pid: int, clients: int, browser: str | None) -> None:
    """All figures of one server."""
    page = Page(base_url=f"{url}/api/v1", timeout=120)
    page.get("/session")
    while page.get("/devices").json()[0]["reach"] != "online":
        time.sleep(0.1)
    run, points = scan(page, runs, pid, 1, None)
    if clients > 1 or browser:
        scan(page, runs, pid, clients, browser)
    counts = "\n".join(f"{190 + i / 30:.4f},{i % 997}" for i in range(CHANNELS))
    (runs / run / "one.csv").write_text(f"wavelength,intensity\n{counts}\n")
    many = page.start("many.yaml")
    page.until_over(many)
    smallest = page.took_ms("/session")
    print(f"the smallest answer: {smallest:.2f} ms")
    for what, ms in (
        ("a map of the points", page.took_ms(f"/runs/{run}/maps/data.csv/Li")),
        (f"a spectrum of {CHANNELS:,} channels", page.took_ms(f"/runs/{run}/spectrum", file="one.csv")),
        (f"all {points:,} points", page.took_ms(f"/runs/{run}/points", loop="main/scan")),
        ("outline and states of 100,000 rows", page.took_ms(f"/runs/{many}")),
        ("10,000 of 100,000 rows", page.took_ms(f"/runs/{many}/points", loop="main/many", limit=10_000)),
    ):  # fmt: skip
        print(f"{what}: {ms:.1f} ms, {ms / smallest:.0f} times the smallest")
    before, began = cpu_s(pid), time.perf_counter()
    time.sleep(10)
    spent = (cpu_s(pid) - before) / (time.perf_counter() - began)
    print(f"processor use when idle: {100 * spent:.1f} %")


def cpu_s(pid: int) -> float:
    """Seconds of processor time that a process has used (Linux; elsewhere 0)."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
