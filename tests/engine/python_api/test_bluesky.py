"""A stock RunEngine runs a plan on a lab's devices: documents come out, and lease and ledger hold."""

import pytest

import labrun
from labrun.engine.python_api.bluesky import Movable, Readable

pytestmark = [pytest.mark.filterwarnings("default")]


@pytest.fixture
def lab():
    with labrun.lab(yes=True) as lab:
        yield lab


def test_it_is_read_and_moved_as_bluesky_does(lab):
    gantry = Movable(lab.gantry, "move_to", "x", name="x")
    with pytest.raises(ValueError, match="x has not moved yet"):
        gantry.read()
    ended = []
    status = gantry.set("12 mm")
    status.add_callback(ended.append)
    status.wait(20)
    beyond = gantry.set("12 m")

    assert ended == [status] and status.success
    assert gantry.read()["x_x"]["value"] == pytest.approx(12, abs=0.1)
    assert gantry.describe()["x_x"]["units"] == "mm"
    assert "x" in str(beyond.exception(20)) and not beyond.success
    with pytest.raises(ValueError, match="tare of balance is not pure"):
        Readable(lab.balance, "tare")


def test_a_status_says_how_it_ended(lab):
    gantry = Movable(lab.gantry, "move_to", "x", name="x")
    moved, beyond = gantry.set("12 mm"), gantry.set("12 m")
    moved.wait(20)

    assert beyond.exception(20) is not None
    assert repr(moved) == "<succeeded>"
    assert repr(beyond).startswith("<failed: ") and "12000 mm" in repr(beyond)


def test_what_returns_no_place_is_where_it_was_set(bench):
    with labrun.lab(bench.lab, yes=True) as lab:
        device = Movable(lab.a, "act", "name", name="a")
        device.set("here").wait(500)

        assert device.hints == {"fields": ["a_name"]} == {"fields": list(device.describe())}
        assert device.read()["a_name"]["value"] == "here"


@pytest.mark.needs("bluesky")
def test_a_plan_on_a_device_that_another_holds_fails_and_its_document_says_who_has_it(bench):
    from bluesky import RunEngine
    from bluesky.plan_stubs import mv
    from bluesky.preprocessors import run_decorator

    documents = []
    with labrun.lab(bench.lab, yes=True) as one, labrun.lab(bench.lab, yes=True) as two:
        one.a.act(name="mine")
        mine, theirs = (Movable(lab.a, "act", "name", name="a") for lab in (one, two))

        @run_decorator()
        def plan(movable):
            yield from mv(movable, "x")

        with pytest.raises(Exception, match="is held by call-"):
            RunEngine({})(plan(theirs), lambda kind, document: documents.append((kind, document)))
        RunEngine({})(plan(mine))

    assert [kind for kind, _ in documents] == ["start", "stop"]
    assert documents[-1][1]["exit_status"] == "fail"
    assert "is held by call-" in documents[-1][1]["reason"]


@pytest.mark.needs("bluesky")
def test_a_stock_run_engine_scans_and_documents_come_out(lab):
    from bluesky import RunEngine
    from bluesky.plans import scan

    documents = []
    gantry = Movable(lab.gantry, "move_to", "x", name="x")
    RunEngine({})(
        scan([Readable(lab.balance, "weigh")], gantry, 10, 30, 3),
        lambda kind, document: documents.append((kind, document)),
    )
    events = [document["data"] for kind, document in documents if kind == "event"]

    assert [kind for kind, _ in documents] == ["start", "descriptor", *["event"] * 3, "stop"]
    assert [event["x_x"] for event in events] == pytest.approx([10, 20, 30], abs=0.1)
    assert documents[-1][1]["exit_status"] == "success"
