"""Each line of the promise is really compared with what happened."""

from hashlib import sha256

import pytest

from labrun.engine.torture.accounts import Account, Deed
from labrun.engine.torture.verdict import PROMISES, Measure, judge
from labrun.schemas import journal as j
from labrun.schemas.messages import GoalError

RUN = "r"
SHOOT = f"{RUN}/main/scan/0/shoot/1"
RIGHT = Measure(
    fate="succeeded", iterations={"main/scan/0": "succeeded"},
    facts={"main/scan/0/shoot": {"x": 1, "focus": 1.0}}, safe={"libs"}, lasts_s=1, writes=9,
)  # fmt: skip


def deed(goal=SHOOT, **facts):
    return Deed("libs", "shot", goal, {"x": 1, "focus": 1.0, **facts})


def sent(goal=SHOOT):
    return j.GoalSent(
        id=goal, device="libs", action="measure", effect="once", boot="b", ledger="l", epoch=1,
        means="m",
    )  # fmt: skip


def over(goal=SHOOT, error=None, **more):
    state = "ABORTED" if error else "SUCCEEDED"
    return j.GoalEnded(id=goal, state=state, error=error, **more)


def row(fate="succeeded", **cells):
    return j.IterationEnded(
        loop="main/scan", index=0, key="0", fate=fate, row={"shot": "s", **cells}
    )


def kept(tmp_path):
    """A run in which everything is as it should be."""
    (tmp_path / RUN).mkdir()
    return Account(
        folder=tmp_path / RUN, deeds=[deed()], sent={SHOOT: sent()}, ended={SHOOT: over()},
        iterations={"main/scan/0": [row()]}, safe={"libs": True},
        finished=j.Finished(fate="succeeded"),
    )  # fmt: skip


def broken(account):
    return {breach.promise for breach in judge(account, RIGHT)}


def test_a_run_in_order_breaks_nothing(tmp_path):
    assert broken(kept(tmp_path)) == set()


def a_second_shot(account):
    account.deeds.append(deed())


def a_second_attempt(account):
    again = SHOOT.replace("/1", "/2")
    account.deeds.append(deed(again))
    account.sent[again], account.ended[again] = sent(again), over(again)


def a_point_less(account):
    account.iterations.clear()


def a_point_twice(account):
    account.iterations["main/scan/0"].append(row())


def an_empty_cell(account):
    account.iterations["main/scan/0"] = [row(Li=None)]


def a_shot_from_nowhere(account):
    account.deeds.append(deed(f"{RUN}/main/other/1"))


def a_fate_that_nobody_asked_for(account):
    del account.ended[SHOOT]


def a_shot_out_of_focus(account):
    account.deeds[0] = deed(focus=0.2)


def a_file_that_is_gone(account):
    account.ended[SHOOT] = over(files={"a.csv": sha256(b"").hexdigest()})


def a_file_that_is_another(account):
    (account.folder / "a.csv").write_bytes(b"other")
    account.ended[SHOOT] = over(files={"a.csv": sha256(b"").hexdigest()})


def a_device_that_is_not_safe(account):
    account.safe["libs"] = False


def another_end(account):
    account.finished = j.Finished(fate="failed", reason="why")


@pytest.mark.parametrize(
    ("harm", "promise"),
    [
        (a_second_shot, "twice"), (a_second_attempt, "twice"), (a_point_less, "lost"),
        (a_point_twice, "lost"), (an_empty_cell, "lost"), (a_shot_from_nowhere, "announced"),
        (a_fate_that_nobody_asked_for, "known"), (a_shot_out_of_focus, "place"),
        (a_file_that_is_gone, "files"), (a_file_that_is_another, "files"),
        (a_device_that_is_not_safe, "safe"), (another_end, "end"),
    ],
)  # fmt: skip
def test_every_harm_is_the_breach_of_one_promise(tmp_path, harm, promise):
    account = kept(tmp_path)
    harm(account)

    assert broken(account) == {promise}
    assert promise in PROMISES


def test_a_shot_again_after_the_device_said_what_went_wrong_is_no_breach(tmp_path):
    account = kept(tmp_path)
    a_second_attempt(account)
    account.ended[SHOOT] = over(error=GoalError(name="NoSignal", message="", happened="yes"))

    assert broken(account) == set()


def test_a_shot_again_because_a_person_said_so_is_no_breach(tmp_path):
    account = kept(tmp_path)
    a_second_attempt(account)
    account.ended[SHOOT] = over(error=GoalError(name="Lost", message="", happened="unknown"))
    account.choices["main/scan/0/shoot/1/unknown"] = "repeat"

    assert broken(account) == set()
