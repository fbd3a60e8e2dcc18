"""`import labrun`: the same runs, checks and tables as from the command line."""

import asyncio
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import labrun

SCAN = """labrun: 1
name: steps
params:
  pitch: {type: quantity, unit: mm, default: 1 mm}
devices: {gantry: gantry@1}
steps:
  - id: scan
    foreach: {n: "${{ range(3) }}"}
    key: ${{ n }}
    collect: {x: "${{ steps.go.x }}", n: "${{ n }}", note: "${{ '=sum' }}"}
    steps:
      - {id: go, do: gantry.move_to, with: {x: "${{ n * params.pitch }}", y: 0 mm}}
"""
HELLO = Path(labrun.__file__).parent / "protocols" / "hello.yaml"


@pytest.fixture
def protocol(tmp_path):
    path = tmp_path / "steps.yaml"
    path.write_text(SCAN)
    return path


def test_an_import_loads_nothing_of_the_engine():
    program = "import labrun, sys; print([m for m in sys.modules if m.startswith('labrun.')])"
    told = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )

    assert told.stdout.strip() == "[]"
    assert set(labrun.__all__) <= set(dir(labrun))
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        labrun.rnu  # noqa: B018


def test_a_check_tells_what_the_command_tells(protocol):
    good = labrun.check(protocol, pitch="0.5 mm")
    bad = labrun.check(protocol, pitch="2 s")

    assert good.ok and good.problems == []
    assert not bad.ok and "pitch" in bad.problems[0].message


def test_what_cannot_run_is_told_before_anything_begins(protocol, tmp_path):
    with pytest.raises(labrun.ProtocolFault, match="pitch") as told:
        labrun.run(protocol, runs=tmp_path / "runs", pitch="2 s")

    assert told.value.problems[0].code.startswith("E")
    assert not (tmp_path / "runs").exists()


def test_a_run_leaves_what_the_command_leaves_and_shows_itself(tmp_path, capsys):
    run = labrun.run(HELLO, runs=tmp_path / "runs", there="4 cm")
    shown = run._repr_html_()

    assert run.fate == "succeeded"
    assert str(run.outputs["x"]) == "40.0 millimeter"
    assert "Hello from x = 40 mm" in capsys.readouterr().out
    assert labrun.load("last", tmp_path / "runs").id == run.id
    assert [one.id for one in labrun.runs(tmp_path / "runs")] == [run.id]
    assert next(iter(run.journal)).kind == "started"
    assert "hello" in shown and "succeeded" in shown and run.id in repr(run)


def test_a_loops_table_has_its_units(protocol, tmp_path):
    pytest.importorskip("xarray")
    run = labrun.run(protocol, runs=tmp_path / "runs", progress=False, params={"pitch": "2 mm"})
    frame, data = run.table(), run.dataset()

    assert run.tables == ["data"] and list(frame.index) == ["0", "1", "2"]
    assert list(frame["x_mm"]) == pytest.approx([0, 2, 4], abs=0.01) and frame.attrs["units"] == {"x_mm": "mm"}
    assert list(frame["note"]) == ["=sum"] * 3  # as it was, not as a spreadsheet must see it
    assert list(data["x"].values) == list(frame["x_mm"]) and data["x"].attrs == {"units": "mm"}
    assert data.attrs["run"] == run.id
    with pytest.raises(ValueError, match="no table 'rows'; it has data"):
        run.table("rows")


def test_it_runs_within_a_running_loop_which_goes_on(tmp_path):
    async def cell():
        ticks = 0

        async def tick():
            nonlocal ticks
            while True:
                ticks += 1
                await asyncio.sleep(0.02)

        ticking = asyncio.create_task(tick())
        run = await labrun.arun(HELLO, runs=tmp_path / "runs", progress=False)
        ticking.cancel()
        return run.fate, ticks

    fate, ticks = asyncio.run(cell())

    assert fate == "succeeded" and ticks > 5


LONG = """labrun: 1
name: long
devices: {gantry: gantry@1}
steps:
  - foreach: {n: "${{ range(100000) }}"}
    steps:
      - wait: 50 ms
finally:
  - {do: gantry.home}
"""


@pytest.fixture
def live(tmp_path):
    path = tmp_path / "long.yaml"
    path.write_text(LONG)
    run = labrun.start(path, runs=tmp_path / "runs", progress=False)
    yield run
    run.abort()
    run.wait()


def test_a_live_run_is_aborted_and_ends_in_order(live):
    with pytest.raises(TimeoutError, match="it goes on"):
        live.wait(timeout=0.1)
    live.abort()
    ended = live.wait()
    done = [r.id for r in ended.journal if r.kind == "ended"]

    assert ended.fate == "aborted"
    assert len(done) == 1  # `finally` homes the gantry
    assert not [thread for thread in threading.enumerate() if thread.name == f"run {ended.id}"]
    assert "ended" in repr(live)


def test_a_cancelled_coroutine_aborts_its_run(tmp_path):
    path = tmp_path / "long.yaml"
    path.write_text(LONG)

    async def cell():
        running = asyncio.create_task(labrun.arun(path, runs=tmp_path / "runs", progress=False))
        while not list((tmp_path / "runs").glob("*/journal.jsonl")):  # noqa: ASYNC110 - a file
            await asyncio.sleep(0.05)
        running.cancel()
        await asyncio.wait({running})
        return running.cancelled()

    assert asyncio.run(cell())
    assert labrun.load("last", tmp_path / "runs").fate == "aborted"


@pytest.mark.posix("signals of POSIX")
def test_ctrl_c_aborts_as_in_a_terminal(tmp_path):
    (tmp_path / "long.yaml").write_text(LONG)
    program = (
        "import signal, labrun\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)  # may be ignored here\n"
        "run = labrun.run('long.yaml')\n"
        "print('fate', run.fate, run.summary.reason)\n"
    )
    made = subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    while not list(tmp_path.glob("runs/*/journal.jsonl")):
        time.sleep(0.05)
    time.sleep(0.5)
    made.send_signal(2)
    told = made.communicate()[0]

    assert made.returncode == 0, told
    assert "fate aborted" in told and "Ctrl-C" in told


def test_a_rehearsal_gives_its_figures(protocol):
    figures = labrun.rehearse(protocol, fail={"gantry.move_to": 1.0}, seed=1)

    assert labrun.rehearse(protocol)["fate"] == "succeeded"
    assert figures["fate"] == "failed"
