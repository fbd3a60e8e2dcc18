"""Figures beside a run: real processes that end with the run, however it ends."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from labrun.engine.runner.draw_live import draw
from labrun.engine.runner.live_figures import live_figures

HEADER = "key,x_mm,y_mm,Li\n"
ROWS = "a,0,0,5\nb,1,0,6\nc,0,1,7\nd,1,1,8\n"
UP_S = 500


@pytest.fixture
def run(tmp_path):
    """What live figures see of a run: its folder, and a line for the screen."""
    told = []
    (tmp_path / "data.csv").write_text(HEADER + ROWS)
    return SimpleNamespace(folder=tmp_path, log=told.append, told=told)


async def until(true):
    async with asyncio.timeout(UP_S):
        while not true():  # noqa: ASYNC110 - other processes tell of no event
            await asyncio.sleep(0.05)


def test_the_map_grows_with_the_rows_and_is_told_of_once(run):
    figure = run.folder / "element_maps.png"

    async def story():
        async with live_figures(run, every_s=0.2):
            await until(lambda: run.told)
            first = figure.read_bytes()
            with (run.folder / "data.csv").open("a") as file:
                file.write("e,2,0,5\nf,2,1,50\n")
            await until(lambda: figure.read_bytes() != first)

    asyncio.run(story())

    assert run.told == [f"{figure} is updated during the run"]
    assert sorted(path.name for path in run.folder.iterdir()) == ["data.csv", "element_maps.png"]


def test_a_line_that_grew_into_an_area_is_an_area_only(run):
    rows = run.folder / "data.csv"
    rows.write_text(HEADER + "a,0,0,5\nb,1,0,6\nc,2,0,7\n")

    async def story():
        async with live_figures(run, every_s=0.2):
            await until(lambda: run.told)
            with rows.open("a") as file:
                file.write("d,0,1,7\ne,1,1,8\nf,2,1,9\n")
            await until(lambda: len(run.told) == 2)

    asyncio.run(story())

    assert [line.split("/")[-1] for line in run.told] == [
        "line_scan.png is updated during the run", "element_maps.png is updated during the run",
    ]  # fmt: skip
    assert sorted(path.name for path in run.folder.iterdir()) == ["data.csv", "element_maps.png"]


def test_a_run_that_is_soon_over_starts_no_process(run, monkeypatch):
    started = []
    monkeypatch.setattr(asyncio, "create_subprocess_exec", started.append)

    async def story():
        async with live_figures(run, every_s=30.0):
            await asyncio.sleep(0.05)

    asyncio.run(story())

    assert started == []


def test_where_it_is_not_wanted_nothing_is_drawn(run):
    async def story():
        async with live_figures(run, wanted=False, every_s=0.0):
            await asyncio.sleep(0.2)

    asyncio.run(story())

    assert not (run.folder / "element_maps.png").exists()


def test_a_fault_of_the_run_passes_through(run):
    async def story():
        async with live_figures(run, every_s=0.0):
            raise RuntimeError("of the run")

    with pytest.raises(RuntimeError, match="of the run"):
        asyncio.run(story())


def beside(folder):
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "labrun.engine.runner.draw_live", str(folder), "0.2"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip


def test_the_process_ends_when_the_engine_is_gone(run):
    process = beside(run.folder)
    name = process.stdout.readline()
    process.stdin.close()  # as the system does for a process that was killed

    assert name == b"element_maps.png\n"
    assert process.wait(10) == 0
    process.stdout.close()


@pytest.mark.skipif(os.name == "nt", reason="a signal of POSIX")
def test_a_process_that_hangs_is_ended_with_the_run(run):
    def children():
        listed = subprocess.run(
            ["pgrep", "-f", f"draw_live {run.folder}"], capture_output=True, text=True
        )
        return [int(pid) for pid in listed.stdout.split()]

    async def story():
        async with live_figures(run, every_s=0.2):
            await until(lambda: run.told)
            os.kill(children()[0], signal.SIGSTOP)
            return time.monotonic()

    stopped = asyncio.run(story())

    assert children() == []
    assert time.monotonic() - stopped < 30


def test_a_maker_that_fails_costs_the_others_nothing(tmp_path):
    def broken(folder):
        raise OSError("no disk")

    names = draw(tmp_path, [broken, lambda folder: {"map.png": b"drawn"}])

    assert names == ["map.png"]
    assert (tmp_path / "map.png").read_bytes() == b"drawn"
    assert [path.name for path in tmp_path.iterdir()] == ["map.png"]
