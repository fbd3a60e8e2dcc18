"""Which attempts of earlier sessions bear on an action that is to be done now."""

from types import SimpleNamespace

import pytest

from labrun.engine.journal.past import Past, PastGoal
from labrun.engine.run.strands import Strands
from labrun.engine.tree.nodes.earlier import EarlierAttempts
from labrun.schemas import journal as j
from labrun.schemas.contract import Action
from labrun.schemas.messages import GoalError

SENT = j.GoalSent(
    n=2, id="r/main/set/1", device="a", action="set", effect="idempotent", boot="b", ledger="l",
    epoch=1, means="m",
)  # fmt: skip
DONE = j.GoalEnded(n=3, id=SENT.id, state="SUCCEEDED")
FAILED = j.GoalEnded(n=3, id=SENT.id, state="ABORTED", error=GoalError(name="Broken"))


@pytest.mark.parametrize(
    ("effect", "ended", "used_n", "strand", "comparing", "came"),
    [
        ("idempotent", DONE, 5, "theirs", False, True),
        ("idempotent", DONE, 5, "ours", False, False),
        ("idempotent", DONE, 2, "theirs", False, False),  # before it was set
        ("idempotent", FAILED, 5, "theirs", False, False),
        ("once", DONE, 5, "theirs", False, False),
        ("idempotent", DONE, 5, "theirs", True, False),
        ("pure", DONE, 5, "theirs", False, True),
        ("pure, and then something once", DONE, 5, "theirs", False, False),  # not read again
        ("idempotent, and then something once", DONE, 5, "theirs", False, True),
    ],
)
def test_what_was_set_counts_no_more_once_another_strand_has_used_its_device(
    effect, ended, used_n, strand, comparing, came
):
    strands = Strands()
    strands.note("a", used_n, strand)
    strands.note("b", 9, "theirs")
    effect, _, then = effect.partition(",")
    history = SimpleNamespace(once_n=4 if then else 2)
    run = SimpleNamespace(past=Past(comparing=comparing), strands=strands, history=history)
    earlier = EarlierAttempts(run, None, Action(effect=effect))

    assert earlier.others_came(PastGoal(SENT, ended, state_n=3), "ours") is came


@pytest.mark.parametrize(
    ("ended", "n", "kept"),
    [(None, 2, True), (None, 5, False), (DONE, 5, True), (DONE, 3, False), (DONE, 2, True)],
)
def test_what_nothing_waited_for_any_more_is_forgotten(ended, n, kept):
    past = Past(goals={"main/set": {1: PastGoal(SENT, ended)}})
    past.forget_under_way("main", n)

    assert (past.goal("main/set", 1) is not None) is kept


def test_of_two_strands_that_take_turns_each_is_seen_by_the_other():
    strands = Strands()
    for n, strand in ((4, "ours"), (5, "theirs"), (6, "ours")):
        strands.note("a", n, strand)

    assert strands.since("a", 4, "ours") and strands.since("a", 5, "theirs")
    assert not strands.since("a", 5, "ours")
    strands.clear()
    assert not strands.since("a", 0, "ours")
