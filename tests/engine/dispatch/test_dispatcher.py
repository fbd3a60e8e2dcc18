"""The dispatcher by itself: what it makes of what its devices' clients tell it."""

import asyncio
import time
from types import SimpleNamespace

import pytest

from labrun.engine.dispatch.dispatcher import Dispatcher, _at
from labrun.engine.run.requests import Requests
from labrun.engine.run.virtual_time import VirtualLoop
from labrun.engine.tree.tick import DRAIN_S


def test_a_stop_counts_where_it_is_heeded_and_only_of_a_device_that_the_run_uses():
    client = SimpleNamespace()
    dispatcher = Dispatcher(SimpleNamespace(roles={}), {"a": client})
    seen = []
    for heeds, device, words in (
        (False, "a", "in `finally`"),
        (True, "b", "on the same server"),
        (True, "a", "first"),
        (True, "a", "second"),
    ):
        dispatcher.heeds_stops = heeds
        client.on_stopped(device, words)
        seen.append(dict(dispatcher.stopped))

    assert seen == [{}, {}, {"a": "first"}, {"a": "first"}]


def test_what_is_waited_for_is_told_with_the_time_at_which_it_was_sent(monkeypatch):
    monkeypatch.setattr(time, "time", lambda: 1_000_000.0)

    assert _at(600.0) == time.strftime("%H:%M:%S", time.localtime(999_400.0))


def test_the_tree_is_ticked_again_where_a_reservation_was_granted_and_only_there():
    run = SimpleNamespace(requests=Requests(), roles={})
    dispatcher = Dispatcher(run, {"a": SimpleNamespace()})
    dispatcher.reservations.ask(["a"], None)
    again = []
    for _ in range(2):
        dispatcher._grant()
        again.append(run.requests.take_round()[0])

    assert again == [True, False]


def test_a_probe_is_queued_before_what_waits_for_its_device():
    dispatcher = Dispatcher(SimpleNamespace(roles={}), {"a": SimpleNamespace()})
    for name, first in (("one", False), ("two", False), ("probe", True)):
        dispatcher.request(SimpleNamespace(device="a", goal_id=name, outcome=None), first=first)

    assert [request.goal_id for request in dispatcher._queue] == ["probe", "one", "two"]


@pytest.mark.parametrize(("grace_s", "waited_s"), [(3.0, 120.0), (600.0, 602.0)])
def test_what_was_cancelled_is_waited_for_as_long_as_its_contract_says(grace_s, waited_s):
    async def drained():
        run = SimpleNamespace(journal=SimpleNamespace(flush=lambda: None), roles={})
        dispatcher = Dispatcher(run, {"a": SimpleNamespace()})
        role = SimpleNamespace(contract=SimpleNamespace(cancel_grace_s=grace_s))
        dispatcher._under_way["g"] = SimpleNamespace(role=role, sent_at=0.0)
        loop = asyncio.get_running_loop()
        began = loop.time()
        return await dispatcher.drain(DRAIN_S), loop.time() - began

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        ended, took_s = runner.run(drained())

    assert (ended, took_s) == (False, pytest.approx(waited_s))
