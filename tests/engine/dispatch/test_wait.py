"""A run waits for devices that another client holds: for all of them or for none."""

import asyncio
import contextlib
import time
from threading import Thread

import pytest
import typer

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.client.lease_keeper import LeaseHeld
from labrun.engine.check import check_file
from labrun.engine.commands.run import start, waiting_s
from labrun.engine.dispatch import connect
from labrun.engine.exit_status import NOT_REACHED

HEAD = "labrun: 1\nname: waits\ndevices: {a: scripted@1, b: scripted@1}\n"
STEPS = "steps: [{do: a.act, with: {name: x}}, {do: b.act, with: {name: y}}]\n"


class Holder(Thread):
    """Another client, which holds `b` until it is let go, and then looks whether `a` is free."""

    def __init__(self, url):
        super().__init__()
        self.url, self.a_was_free = url, False
        self.holds, self.over = asyncio.Event(), asyncio.Event()
        self.start()

    def run(self):
        asyncio.run(self._hold())

    async def _hold(self):
        self.loop = asyncio.get_running_loop()
        client = DeviceClient(self.url)
        await client.open(20)
        await client.take_lease("b", "somebody")
        self.holds.set()
        await self.over.wait()
        for _ in range(100):  # the waiting run has it while it asks for both, and no longer
            with contextlib.suppress(LeaseHeld):
                await client.take_lease("a", "somebody")
                self.a_was_free = True
                await client.release("a")
                break
            await asyncio.sleep(0.02)
        await client.release("b")
        await client.close()

    def let_go(self):
        with contextlib.suppress(RuntimeError):  # it has let go already, and its loop is closed
            self.loop.call_soon_threadsafe(self.over.set)


@pytest.fixture
def held(bench, tmp_path, monkeypatch):
    monkeypatch.setattr(connect, "LOOK_S", 0.2)
    (tmp_path / "w.yaml").write_text(HEAD + STEPS)
    checked = check_file(tmp_path / "w.yaml", lab=bench.lab)
    holder = Holder(checked.lab.lab.devices["b"].url)
    while not holder.holds.is_set():
        time.sleep(0.01)
    yield checked, holder, tmp_path / "runs"
    holder.let_go()
    holder.join()


def test_a_run_begins_when_its_devices_are_free(bench, held, capsys):
    checked, holder, runs = held
    said = ""

    def let_go_when_it_waits():
        nonlocal said
        while "waiting for b, which somebody holds; Ctrl-C ends the wait" not in said:
            time.sleep(0.02)
            said += capsys.readouterr().err
        holder.let_go()

    later = Thread(target=let_go_when_it_waits, daemon=True)
    later.start()

    status = start(checked, runs, wait_s=60)
    later.join()
    (run,) = runs.iterdir()

    assert status == 0
    assert holder.a_was_free
    assert [c["name"] for c in bench.calls(run.name) if c["word"] == "done"] == ["x", "y"]


@pytest.mark.parametrize("wait_s", [0.0, 0.5])
def test_a_wait_has_an_end_and_leaves_nothing_behind(held, capsys, wait_s):
    checked, _, runs = held

    assert start(checked, runs, wait_s=wait_s) == NOT_REACHED
    assert list(runs.iterdir()) == []
    assert "`labrun run --wait` waits until it is free" in capsys.readouterr().err


def test_what_is_no_time_is_refused(capsys):
    assert waiting_s("90 min") == 5400
    with pytest.raises(typer.Exit):
        waiting_s("5 mm")

    assert "write a time" in capsys.readouterr().err
