"""What has happened according to a journal's records."""

import pytest

from labrun.engine.journal.course import split_goal_id
from labrun.engine.journal.history import read_history
from labrun.engine.journal.journal import JournalFault
from labrun.engine.journal.past import without_passes
from labrun.schemas import journal as j
from labrun.schemas.messages import GoalError

STARTED = j.Started(n=1, run="r", protocol="p", labrun="0", python="3")
LOST = GoalError(name="Lost", message="", happened="no")

BROKEN = GoalError(name="Broken", happened="no")


def sent(n, path="main/scan/0/shoot", attempt=1, device="a", epoch=1, effect="idempotent", sets=""):
    return j.GoalSent(
        n=n, id=f"r/{path}/{attempt}", device=device, action="act", effect=effect,
        boot="b", ledger="l", epoch=epoch, means="m", sets=sets,
    )  # fmt: skip


def ended(n, path="main/scan/0/shoot", attempt=1, error=None):
    state = "ABORTED" if error else "SUCCEEDED"
    return j.GoalEnded(n=n, id=f"r/{path}/{attempt}", state=state, error=error)


def test_a_goal_id_is_its_path_and_attempt():
    assert split_goal_id("r/main/scan/0,0/shoot/2") == ("main/scan/0,0/shoot", 2)


def test_a_goal_without_an_end_is_open():
    history = read_history([STARTED, sent(2)])

    assert [past.sent.n for past in history.past.open_goals()] == [2]


def test_every_attempt_without_an_end_is_open():
    history = read_history([STARTED, sent(2), sent(3, attempt=2)])

    assert [past.sent.n for past in history.past.open_goals()] == [2, 3]


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


@pytest.mark.parametrize(
    ("path", "plain"),
    [
        ("main/scan/4,1/shoot", "main/scan/4,1/shoot"),
        ("main/scan/4,1/pass:2/shoot", "main/scan/4,1/shoot"),
        ("main/scan/4,1/pass:2/deep/0/pass:3/shoot", "main/scan/4,1/deep/0/shoot"),
    ],
)
def test_the_levels_of_later_passes_are_not_in_the_protocol(path, plain):
    assert without_passes(path) == plain


def test_each_time_that_finally_begins_is_counted():
    phases = [j.Phase(n=2, phase="main"), j.Phase(n=3, phase="finally:1")]

    assert [read_history([STARTED, *phases[:n]]).finals for n in (0, 1, 2)] == [0, 0, 1]


def test_failures_before_the_end_of_a_run_are_spent_when_it_goes_on():
    records = [
        STARTED, sent(2), ended(3, error=BROKEN), j.Finished(n=4, fate="failed"),
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


def leases(*told):
    """A history with a goal sent under the first of some leases: n, boot, epoch, continues."""
    first, *later = (
        j.Leased(n=n, device="a", boot=boot, epoch=epoch, mark=f"m{n}", continues=continues)
        for n, boot, epoch, continues in told
    )
    return read_history([STARTED, first, sent(3, device="a", epoch=first.epoch), *later])


@pytest.mark.parametrize(
    ("later", "ours", "remembered"),
    [
        ([(4, "l.2", 6, True)], True, True),
        ([(4, "l.2", 7, True)], False, True),  # somebody held it under 6
        ([(4, "l.2", 6, False)], False, False),  # an older copy of the ledger
        ([(4, "other.1", 5, True)], False, False),  # another one, with the same number
        ([(4, "l.2", 6, False), (5, "l.3", 7, True)], False, False),
    ],
)
def test_epochs_prove_who_held_a_device_within_one_ledger_only(later, ours, remembered):
    history = leases((2, "l.1", 5, True), *later)
    goal = history.past.goal("main/scan/0/shoot", 1).sent

    assert (history.held_since(goal), history.is_remembered(goal)) == (ours, remembered)


def test_a_new_lease_follows_the_last_one_only_in_the_same_ledger():
    history = leases((2, "l.1", 5, True))

    assert not history.somebody_was_there("a", "l.2", 6)
    assert history.somebody_was_there("a", "l.2", 7)
    assert history.somebody_was_there("a", "other.1", 6)


def test_the_newest_mark_of_a_device_is_remembered():
    history = leases((2, "l.1", 5, True))
    history.take(j.Marked(n=9, device="a", mark="newer"))

    assert history.marks == {"a": "newer"}


def is_replaced(*records):
    """Whether what was set first was about to be set otherwise."""
    up = [sent(2, path="main/up", sets="heat"), ended(3, path="main/up")]
    history = read_history([STARTED, *up, *records])
    return history.is_replaced(history.past.goal("main/up", 1))


def test_what_was_set_is_replaced_by_the_next_thing_that_sets_it():
    down = sent(6, path="main/down", sets="heat")
    ends = ended(7, path="main/down"), ended(7, path="main/down", error=BROKEN)
    stopped = ended(7, path="main/down", error=GoalError(name="Stopped", happened="unknown"))
    safe = j.SafeState(n=4, device="a", confirmed=True)
    redo = j.Redo(n=8, iterations=[], pass_number=2, by="Ada")

    assert is_replaced(down)
    assert is_replaced(sent(4, effect="once"), down, ends[0])
    assert is_replaced(down, stopped, sent(8, path="main/down", attempt=2, sets="heat"))
    assert is_replaced(down, sent(8, path="main/off", sets="heat"))
    assert not is_replaced()
    assert not is_replaced(sent(4, effect="pure"), down)  # which is read again
    assert not is_replaced(sent(6, path="main/down", sets="channel 2"))
    assert not is_replaced(safe, down)
    assert not is_replaced(sent(6, path="main/up", attempt=2, sets="heat"))
    assert not is_replaced(down, ends[1])  # it may have set nothing
    assert not is_replaced(down, redo)
    assert not is_replaced(
        down, j.Finished(n=8, fate="failed"), j.Resumed(n=9, count=1, labrun="0")
    )


@pytest.mark.parametrize(("put_back", "doubtful"), [(None, set()), (True, {"a"})])
def test_a_device_whose_ledger_went_back_with_the_journal_is_doubtful(put_back, doubtful):
    resumed = j.Resumed(n=3, count=1, labrun="0", put_back=put_back)
    leases = [
        j.Leased(n=n, device="a", epoch=n, boot="l.1", mark="", continues=n == 2) for n in (2, 4)
    ]
    history = read_history([STARTED, leases[0], resumed, leases[1], sent(5, effect="once")])

    assert history.doubtful == doubtful
    assert history.is_remembered(sent(5)) is not bool(doubtful)


def test_a_goal_that_the_journal_does_not_have_is_not_taken_for_an_earlier_one():
    history = read_history([STARTED, sent(2, "main/x", effect="once"), sent(3, effect="once")])
    newest = "r/main/scan/0/shoot/1"

    assert history.was_before("a", "r/main/x/1", newest)
    assert not history.was_before("a", "r/main/y/1", newest)


@pytest.mark.parametrize(
    ("newest", "doubtful"),
    [("r/main/y/1", {"a"}), ("r/main/x/1", set()), ("other/main/y/1", set()), (None, set()), ("", set())],
)  # fmt: skip
def test_a_probe_that_names_a_goal_which_the_journal_does_not_have_tells_that_it_went_back(
    newest, doubtful
):
    probe = "main/newest/a/last_shot/1/probe"
    told = ended(5, probe).model_copy(update={"result": {"goal_id": newest}})
    lease = j.Leased(n=2, device="a", epoch=1, boot="l.1", mark="")
    history = read_history([STARTED, lease, sent(3, "main/x", effect="once"), sent(4, probe), told])

    assert history.doubtful == doubtful
