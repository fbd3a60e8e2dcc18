"""What a probe's answer proves about a `once` action, and what it does not."""

import asyncio
from dataclasses import dataclass, replace

import pytest

from labrun.drivers.client.client import Outcome, ServerUnreachable
from labrun.engine.dispatch.probe import (
    STRANGER,
    checked_with_server,
    probe_request,
    told_before,
    told_by,
    what_it_proves,
)
from labrun.engine.journal.history import read_history
from labrun.engine.lab.bind import BoundRole
from labrun.schemas import journal as j
from labrun.schemas.contract import Contract
from labrun.schemas.messages import GoalError

CONTRACT = Contract.model_validate(
    {
        "type": "gun@1",
        "safe_state": [],
        "actions": {
            "fire": {"effect": "once", "probe": "last"},
            "flash": {"effect": "once", "probe": "last", "meanwhile": True},
            "last": {"effect": "pure"},
        },
    }
)
ROLE = BoundRole("gun", "gun", CONTRACT)
OURS = "r/main/1/1"


def leased(n, epoch, boot="l.1", continues=True):
    return j.Leased(
        n=n, device="gun", epoch=epoch, boot=boot, mark="l:1:a", continues=continues
    )  # fmt: skip


def sent(n, path, action="fire", epoch=1):
    return j.GoalSent(
        n=n, id=f"r/{path}/1", device="gun", action=action, effect="once", boot="l.1", ledger="l",
        epoch=epoch, means="m",
    )  # fmt: skip


def history(*more, action="fire"):
    started = j.Started(n=1, run="r", protocol="p", labrun="0", python="3")
    fired = [sent(3, "main/0"), sent(4, "main/1", action), sent(5, "main/2")]
    return read_history([started, leased(2, 1), *fired, *more])


@pytest.mark.parametrize(
    ("newest", "proves"),
    [
        (OURS, True),
        (None, None),  # it does not remember
        ("", False),  # it has never done it
        ("r/main/0/1", False),  # it was asked before ours, and is the newest
        ("r/main/2/1", None),  # it was asked after ours, which it may hide
        ("other/main/0/1", False),  # nobody has held the device since
    ],
)
def test_the_newest_execution_proves_only_what_it_cannot_hide(newest, proves):
    assert what_it_proves(history(), ROLE, OURS, {"goal_id": newest}) is proves
    assert what_it_proves(history(), ROLE, OURS, None) is None


@pytest.mark.parametrize("newest", ["", "r/main/0/1", "other/main/0/1"])
def test_where_things_happen_side_by_side_only_the_goals_own_id_proves_anything(newest):
    beside = replace(ROLE, contract=CONTRACT.model_copy(update={"concurrent": True}))

    assert what_it_proves(history(), beside, OURS, {"goal_id": newest}) is None
    assert what_it_proves(history(action="flash"), ROLE, OURS, {"goal_id": newest}) is None
    assert what_it_proves(history(), ROLE, "r/main/9/1", {"goal_id": newest}) is None
    assert what_it_proves(history(), beside, OURS, {"goal_id": OURS}) is True


def test_another_clients_shot_denies_ours_only_if_nobody_else_held_the_device_since():
    missed = history(leased(6, 3))

    assert what_it_proves(missed, ROLE, OURS, {"goal_id": "other/main/0/1"}) is None
    assert what_it_proves(missed, ROLE, OURS, {"goal_id": "r/main/0/1"}) is False


def ended(state="SUCCEEDED", error=None, goal_id="r/main/0/1"):
    error = error and GoalError(name=error, message="", happened="yes")
    return Outcome(state, {"goal_id": goal_id, "n": 1}, error, {}, "l.1")


@pytest.mark.parametrize(
    ("outcome", "told"),
    [
        (ended(), {"goal_id": "r/main/0/1", "n": 1}),
        (ended(error="Stopped"), {"goal_id": "r/main/0/1", "n": 1}),
        (ended(error=STRANGER), {"goal_id": None, "n": 1}),
        (ended("ABORTED", "Broken"), None),
    ],
)
def test_an_answer_that_proves_nothing_names_no_goal(outcome, told):
    assert told_by(outcome) == told


@dataclass
class Client:
    """As much of a device's client as is asked about a probe."""

    known: tuple[str, ...] = ()
    continues: bool = True
    reached: bool = True

    async def knows(self, goal_id):
        if not self.reached:
            raise ServerUnreachable("http://gun", "no answer")
        return goal_id in self.known


OTHER = "other/main/0/1"


@pytest.mark.parametrize(
    ("newest", "client", "believed"),
    [
        (OURS, Client(continues=False), True),
        (None, Client(continues=False), True),
        ("r/main/0/1", Client(), True),
        ("", Client(), True),
        ("", Client(continues=False), False),
        ("r/main/0/1", Client(continues=False), False),
        (OTHER, Client(known=(OTHER,)), True),
        (OTHER, Client(), False),
        (OTHER, Client(reached=False), False),
    ],
)
def test_a_denial_counts_only_beside_the_ledger_that_ours_was_sent_to(newest, client, believed):
    past = history()
    request = probe_request(past, ROLE, OURS, "fire")
    outcome = asyncio.run(checked_with_server(request, ended(goal_id=newest), client, past))

    assert (outcome.error is None) is believed
    assert outcome.result["goal_id"] == newest


def test_a_denial_of_a_ledger_that_was_replaced_since_counts_for_nothing():
    past = history(leased(6, 1, boot="k.1"))
    request = probe_request(past, ROLE, OURS, "fire")
    outcome = asyncio.run(checked_with_server(request, ended(goal_id=""), Client(), past))

    assert outcome.error.name == STRANGER


@pytest.mark.parametrize(
    ("duration", "timeout_s"), [(None, 60.0), ("1 s", 60.0), ("2 min", 1230.0)]
)
def test_a_probe_may_take_as_long_as_its_contract_lets_any_action_take(duration, timeout_s):
    last = CONTRACT.actions["last"].model_copy(update={"duration": duration})
    told = CONTRACT.model_copy(update={"actions": {**CONTRACT.actions, "last": last}})
    role = replace(ROLE, contract=told)

    assert probe_request(history(), role, OURS, "fire").timeout_s == timeout_s


def test_each_probe_is_a_goal_of_its_own_and_what_one_has_told_is_kept():
    first = probe_request(history(), ROLE, OURS, "fire")
    record = j.GoalSent(
        n=6, id=first.goal_id, device="gun", action="last", effect="pure", boot="l.1", ledger="l",
        epoch=1, means="m",
    )  # fmt: skip
    answer = {"goal_id": OURS}
    over = j.GoalEnded(n=7, id=first.goal_id, state="SUCCEEDED", result=answer)
    past = history(record, over)

    assert first.goal_id == "r/main/1/1/probe/1"
    assert probe_request(past, ROLE, OURS, "fire").goal_id == "r/main/1/1/probe/2"
    assert probe_request(past, ROLE, OURS, "last") is None
    assert told_before(history(record), OURS) is None
    assert told_before(past, OURS) == answer
