"""A run's progress in a notebook: lines, and one bar."""

import io

import pytest

from labrun.engine.python_api.bar import BarWatch
from labrun.schemas.event import Event

pytest.importorskip("tqdm")


def iteration(path, done, state="running", failed=0):
    data = {"done": done, "failed": failed, "total": 3, "key": str(done)}
    return Event(event="iteration", path=path, state=state, data=data)


def test_the_outermost_loop_has_a_bar_to_its_end():
    out = io.StringIO()
    watch = BarWatch(out)
    watch(Event(event="run", path="2026-01-01_map_12345678"))
    watch(iteration("main/scan", 0))
    watch(iteration("main/scan/inner", 2))
    watch(iteration("main/scan/inner", 3, "ended"))
    watch(iteration("main/scan", 3, "ended", failed=1))
    watch(Event(event="log", text="so far"))

    assert "3/3" in out.getvalue() and "1 failed" in out.getvalue()
    assert "2/3" not in out.getvalue()
    assert out.getvalue().startswith("run 2026-01-01_map_12345678\n")
    assert out.getvalue().endswith("so far\n")


def test_a_run_that_ends_in_the_middle_closes_its_bar():
    out = io.StringIO()
    watch = BarWatch(out)
    watch(iteration("main/scan", 1))
    data = {"outputs": {}, "folder": "runs/x", "holes": 0, "resumable": False}
    watch(Event(event="finished", path="x", state="aborted", text="by you", data=data))
    watch(iteration("main/next", 2))
    first, _, rest = out.getvalue().partition("run aborted: by you\n")

    assert "1/3" in first and first.endswith("\n")
    assert "0/3" in rest  # a bar of its own
