"""`import labrun`: the same runs, checks and tables as from the command line."""

import asyncio
import inspect
import io
import json
import re
import subprocess
import sys
import threading
import time
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest

import labrun
from labrun.schemas.quantity import quantity

SCAN = """labrun: 1
name: steps
params:
  pitch: {type: quantity, unit: mm, default: 1 mm}
devices: {gantry: gantry@1}
steps:
  - id: scan
    foreach: {n: "${{ range(3) }}"}
    key: "=${{ n }}"
    collect: {x: "${{ steps.go.x }}", n: "${{ n }}", note: "${{ '=sum' }}", what: "${{ 'NA' }}"}
    steps:
      - {id: go, do: gantry.move_to, with: {x: "${{ n * params.pitch }}", y: 0 mm}}
  - log: pitch ${{ params.pitch }}
outputs: {last: "${{ 2 * params.pitch }}"}
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
    assert all(getattr(labrun, name) for name in labrun.__all__)
    stub = Path(labrun.__file__).with_suffix(".pyi").read_text()
    assert sorted(re.findall(r'"(\w+)"', stub.partition("__all__")[2])) == sorted(labrun.__all__)
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        labrun.rnu  # noqa: B018


def test_a_check_tells_what_the_command_tells(protocol):
    good = labrun.check(protocol, pitch="0.5 mm")
    bad = labrun.check(protocol, pitch="2 s")

    assert good.ok and good.problems == []
    assert not bad and "pitch" in bad.problems[0].message
    assert repr(bad).endswith("Nothing was sent to any device.") and repr(good) == "no problems"
    assert "<b style='color:#c0392b'>error</b>[E" in bad._repr_html_()


def test_what_cannot_run_is_told_before_anything_begins(protocol, tmp_path):
    with pytest.raises(labrun.ProtocolFault, match="pitch") as told:
        labrun.run(protocol, runs=tmp_path / "runs", pitch="2 s")

    assert told.value.problems[0].code.startswith("E")
    assert "is a time" in "\n".join(told.value._render_traceback_())  # all that IPython shows
    assert not (tmp_path / "runs").exists()


def test_a_device_out_of_reach_is_told_in_a_sentence_and_leaves_no_folder(protocol, tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "start_timeout: 1 s\ndevices: {gantry: {contract: gantry@1, url: 'http://127.0.0.1:9'}}\n"
    )
    with pytest.raises(labrun.Refused, match=r"device 'gantry' at .* Nothing was sent\.") as told:
        labrun.run(protocol, runs=tmp_path / "runs", lab=lab, progress=False)

    assert told.value.__suppress_context__  # no traceback of sockets before the sentence
    assert labrun.runs(tmp_path / "runs") == []
    with pytest.raises(labrun.Refused, match="no run 'last' in"):
        labrun.load("last", tmp_path / "runs")


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run, and what was printed meanwhile."""
    folder = tmp_path_factory.mktemp("ran")
    (folder / "steps.yaml").write_text(SCAN)
    with redirect_stdout(io.StringIO()) as out:
        run = labrun.run(folder / "steps.yaml", runs=folder / "runs", params={"pitch": "2 mm"})
    return run, out.getvalue()


def test_a_run_leaves_what_the_command_leaves_and_shows_itself(ran):
    run, printed = ran
    runs = run.folder.parent
    shown = run._repr_html_()

    assert run.fate == "succeeded"
    assert str(run.outputs["last"]) == "4 millimeter"
    assert "pitch 2 mm" in printed and "run succeeded" in printed
    assert labrun.load("last", runs).id == run.id
    assert [one.id for one in labrun.runs(runs)] == [run.id]
    assert next(iter(run.journal)).kind == "started"
    assert run.report is not None and run.spectra == []
    assert "steps" in shown and "succeeded" in shown and "4 mm" in shown and run.id in repr(run)
    with pytest.raises(
        labrun.Refused, match=r"none of 1 runs has data\.x_m; did you mean data\.x_mm"
    ):
        labrun.values("data.x_m", runs)


def test_a_run_that_never_began_is_unreadable_and_no_traceback(tmp_path):
    folder = tmp_path / "2026-11-26_scan_aaaaaaaa"
    folder.mkdir()
    (folder / "journal.jsonl").write_text("")
    run = labrun.load(folder)

    assert "unreadable" in repr(run)
    with pytest.raises(labrun.Refused, match="no start of a run"):
        run._repr_html_()


def test_a_loops_table_has_its_units(ran):
    pytest.importorskip("xarray")
    run, _ = ran
    frame, data = run.table(), run.dataset()

    assert run.tables == ["data"] and list(frame.index) == ["=0", "=1", "=2"]
    assert list(frame["x_mm"]) == pytest.approx([0, 2, 4], abs=0.01)
    assert frame.attrs["units"] == {"x_mm": "mm"}
    assert list(frame["note"]) == ["=sum"] * 3  # as it was, not as a spreadsheet must see it
    assert list(frame["what"]) == ["NA"] * 3
    assert list(data["x"].values) == list(frame["x_mm"]) and data["x"].attrs == {"units": "mm"}
    assert data.attrs["run"] == run.id
    with pytest.raises(labrun.Refused, match="no table 'rows'; it has data"):
        run.table("rows")


@pytest.mark.slow
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
    assert labrun.load(live.folder).fate == "running"  # also while its devices are being reached
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


@pytest.mark.slow
def test_a_program_that_ends_waits_for_its_run(tmp_path):
    (tmp_path / "steps.yaml").write_text(SCAN)
    program = "import labrun\nlabrun.start('steps.yaml')\nprint('the last line')\n"
    ran = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True
    )

    assert ran.stdout.partition("\n")[0] == "the last line"
    assert "run succeeded" in ran.stdout and not ran.stderr
    assert labrun.load("last", tmp_path / "runs").fate == "succeeded"


@pytest.mark.slow
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


def test_a_rehearsal_gives_its_figures_in_a_running_loop_too(protocol):
    async def cell():
        return labrun.rehearse(protocol, fail={"gantry.move_to": 1.0}, seed=1)

    rehearsed = labrun.rehearse(protocol)

    assert rehearsed["fate"] == "succeeded" and str(rehearsed).startswith("The run takes ")
    assert asyncio.run(cell())["fate"] == "failed"
    with pytest.raises(labrun.Refused, match="no role x; roles: gantry"):
        labrun.rehearse(protocol, fail={"x.y": 1})


def answer(live, choice):
    """Answer as soon as the question is open."""
    while True:
        try:
            return live.answer("q", choice)
        except labrun.Refused as fault:
            if "none is open" not in str(fault) and "is not running" not in str(fault):
                raise
        time.sleep(0.02)


def test_a_question_is_answered_from_the_next_cell(tmp_path):
    path = tmp_path / "ask.yaml"
    path.write_text("labrun: 1\nname: ask\nsteps:\n  - {id: q, ask: Which?, choices: [a, b]}\n")
    live = labrun.start(path, runs=tmp_path / "runs", progress=False)
    with pytest.raises(labrun.Refused, match="'c' is not a choice of 'q'; choose a, b"):
        answer(live, "c")
    answer(live, "b")

    assert live.wait().fate == "succeeded"
    with pytest.raises(labrun.Refused, match="is not running"):
        live.answer("q", "b")


PARAMS = """labrun: 1
name: params
params:
  flag: {type: boolean, default: false}
  names: {type: array, items: {type: string}, default: [x]}
  pitch: {type: quantity, unit: mm, default: 1 mm}
  n: {type: integer, default: 1}
steps:
  - require: ${{ params.flag and params.n == 3 and params.names[1] == 'b' and params.pitch == 0.5 mm }}
  - {id: q, ask: Which?, choices: [a, b]}
"""


def test_parameters_are_values_of_python_and_a_resume_reads_them_again(tmp_path):
    (tmp_path / "params.yaml").write_text(PARAMS)
    given = {"flag": True, "names": ["a", "b"], "pitch": quantity(0.5, "mm"), "n": np.int64(3)}
    live = labrun.start(tmp_path / "params.yaml", runs=tmp_path / "runs", progress=False, **given)
    with pytest.raises(labrun.Refused, match="is not a choice"):
        answer(live, "c")  # `require` has been passed
    live.abort()
    run = live.wait()
    texts = json.loads((run.folder / "run.json").read_text())["params"]
    again = labrun.check(tmp_path / "params.yaml", **texts)

    assert run.params == {**given, "n": 3} and run.fate == "aborted"
    assert again.ok and texts["flag"] == "true" and texts["names"] == '["a", "b"]'
    with pytest.raises(TypeError, match="no value of a protocol"):
        labrun.check(tmp_path / "params.yaml", n=object())


def test_run_and_arun_show_the_options_of_start():
    options = inspect.signature(labrun.start).parameters

    assert inspect.signature(labrun.run).parameters == options
    assert inspect.signature(labrun.arun).parameters == options


def test_a_spectrum_is_read(tmp_path):
    (tmp_path / "a.csv").write_text("nm,counts\n200,1\n201,2\n202,4\n")

    assert labrun.read_spectrum(tmp_path / "a.csv").intensity.tolist() == [1, 2, 4]
