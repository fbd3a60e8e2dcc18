"""What has happened according to a journal's records."""

import pytest

from labrun.engine.journal.history import read_history, split_goal_id
from labrun.engine.journal.journal import JournalFault
from labrun.schemas import journal as j
from labrun.schemas.messages import GoalError

STARTED = j.Started(n=1, run="r", protocol="p", labrun="0", python="3")
LOST = GoalError(name="Lost", message="", happened="no")


def sent(n, path="main/scan/0/shoot", attempt=1, device="a"):
    return j.GoalSent(
        n=n, id=f"r/{path}/{attempt}", device=device, action="act", effect="idempotent",
        boot="b", ledger="l", epoch=1, means="m",
    )  # fmt: skip


def ended(n, path="main/scan/0/shoot", attempt=1, error=None):
    state = "ABORTED" if error else "SUCCEEDED"
    return j.GoalEnded(n=n, id=f"r/{path}/{attempt}", state=state, error=error)


def test_a_goal_id_is_its_path_and_attempt():
    assert split_goal_id("r/main/scan/0,0/shoot/2") == ("main/scan/0,0/shoot", 2)


def test_a_goal_without_an_end_is_open():
    history = read_history([STARTED, sent(2)])

    assert [past.sent.n for past in history.past.open_goals()] == [2]


def test_what_lies_in_a_finished_iteration_is_forgotten_but_for_its_count():
    over = j.IterationEnded(n=4, loop="main/scan", index=0, key="0", fate="succeeded")

    history = read_history([STARTED, sent(2), ended(3), over])

    assert history.past.goals == {}
    assert history.past.iterations == {"main/scan": {"0": "succeeded"}}


def test_a_goal_lost_together_with_its_engine_is_no_failure_of_its_step():
    resumed = j.Resumed(n=3, count=1, labrun="0")

    with_engine = read_history([STARTED, sent(2), resumed, ended(4, error=LOST)])
    alone = read_history([STARTED, sent(2), ended(3, error=LOST)])

    assert with_engine.past.goal("main/scan/0/shoot", 1).spent
    assert not alone.past.goal("main/scan/0/shoot", 1).spent


def test_failures_before_the_end_of_a_run_are_spent_when_it_goes_on():
    broken = GoalError(name="Broken", happened="no")
    records = [
        STARTED, sent(2), ended(3, error=broken), j.Finished(n=4, fate="failed"),
        j.Resumed(n=5, count=1, labrun="0"),
    ]  # fmt: skip

    history = read_history(records)

    assert history.past.goal("main/scan/0/shoot", 1).spent
    assert history.past.newest_success("main/scan/0/shoot") is None


def test_a_device_that_was_made_safe_after_a_goal_makes_its_success_stale():
    safe = j.SafeState(n=4, device="a", confirmed=True)

    fresh = read_history([STARTED, sent(2), ended(3)])
    touched = read_history([STARTED, sent(2), ended(3), safe])

    assert not fresh.is_stale(fresh.past.goal("main/scan/0/shoot", 1))
    assert touched.is_stale(touched.past.goal("main/scan/0/shoot", 1))


def test_a_journal_without_a_start_is_refused():
    with pytest.raises(JournalFault, match="no start"):
        read_history([sent(1)])


def test_a_goal_that_was_only_asked_about_later_may_have_lost_its_state_in_between():
    safe = j.SafeState(n=3, device="a", confirmed=True)
    leased = j.Leased(n=4, device="a", epoch=2, boot="b")

    asked = read_history([STARTED, sent(2), safe, leased, ended(5)])
    heard = read_history([STARTED, sent(2), safe, ended(5)])

    assert asked.is_stale(asked.past.goal("main/scan/0/shoot", 1))
    assert not heard.is_stale(heard.past.goal("main/scan/0/shoot", 1))


def test_what_is_asked_of_a_device_outside_the_protocols_own_order_touches_it():
    outside = sent(4, path="finally:1/park", device="a")

    history = read_history([STARTED, sent(2), ended(3), outside])

    assert history.is_stale(history.past.goal("main/scan/0/shoot", 1))


def test_the_past_of_a_tree_learns_nothing_more():
    history = read_history([STARTED, sent(2)])
    past = history.past.copy()
    history.take(ended(3))
    history.take(j.IterationEnded(n=4, loop="main/scan", index=0, key="0", fate="succeeded"))

    assert [goal.sent.n for goal in past.open_goals()] == [2]
    assert past.iterations == {} and history.past.goals == {}
