"""The course of a run as every reader of its journal knows it."""

from pathlib import Path

import pytest

from labrun.engine.journal.course import Course
from labrun.engine.journal.history import History
from labrun.engine.torture.accounts import Account
from labrun.schemas import journal as j
from labrun.web.report.counts import JournalDigest
from labrun.web.runs.picture import Picture

STARTED = j.Started(run="r", protocol="p", labrun="0", python="3", roles={"a": "one"})
ASKED = j.Asked(path="main/ask", id="q1", text="Well?", choices=["yes", "no"])
HOLE = j.IterationEnded(loop="main/scan", index=0, key="0", fate="failed")
CHANGED = j.Changed(
    folder="changes/1", params={"n": 2}, roles={"a": "two"}, reopened=["main/scan/0"]
)
SENT = j.GoalSent(
    id="r/main/go/2", device="a", action="act", effect="idempotent", boot="b", ledger="l",
    epoch=1, means="m",
)  # fmt: skip
ENDED = j.GoalEnded(id=SENT.id, state="SUCCEEDED")
PAUSE = j.Control(verb="pause", by="me")
ABORT = j.Control(verb="abort", by="me")
OVER = j.Finished(fate="aborted")
RESUMED = j.Resumed(count=1, labrun="0")


def after(*records, course=None):
    course = course or Course()
    for n, record in enumerate(records, start=1):
        course.take(record.model_copy(update={"n": n, "at": f"t{n}", "hash": f"h{n}"}))
    return course


def test_a_goal_is_under_way_until_it_ends_also_when_its_engine_has_gone():
    during = after(STARTED, SENT, RESUMED)
    (goal,) = during.under_way.values()

    assert (goal.path, goal.attempt, goal.session, goal.record.label) == ("main/go", 2, 1, "a.act")
    assert (during.session, during.resumes) == (2, 1)
    assert (Course().session, Course().resumes, Course().paused) == (1, 0, False)
    assert not after(STARTED, SENT, RESUMED, ENDED).under_way


def test_a_hole_that_a_change_reopens_is_no_hole_until_it_fails_again():
    assert after(STARTED, HOLE).hole_count == 1
    assert after(STARTED, HOLE, CHANGED).hole_count == 0
    assert after(STARTED, HOLE, CHANGED, HOLE).hole_count == 1
    assert after(STARTED, HOLE, HOLE.model_copy(update={"fate": "succeeded"})).hole_count == 0


def test_an_end_closes_questions_and_a_pause_and_a_resume_takes_back_the_end():
    asked, over = after(STARTED, ASKED, PAUSE), after(STARTED, ASKED, PAUSE, ABORT, OVER)
    again = after(STARTED, ASKED, PAUSE, ABORT, OVER, RESUMED)

    assert (list(asked.open_questions), asked.paused) == (["main/ask"], True)
    assert asked.aborted_by == ""  # a pause is no abort
    assert (list(over.open_questions), over.paused, over.aborted_by) == ([], False, "me")
    assert over.finished.fate == "aborted" and again.finished is None and not again.aborted_by


def test_the_newest_inputs_are_those_of_the_last_change_which_no_engine_wrote():
    older = [CHANGED.model_copy(update={"roles": {"a": name}}) for name in ("none", "other")]
    course = after(STARTED, PAUSE, *older, CHANGED)

    assert (course.roles, after(STARTED).roles, Course().roles) == ({"a": "two"}, {"a": "one"}, {})
    assert (course.params, Course().params) == (CHANGED.params, {}) and CHANGED.params
    assert (course.last_n, course.last_hash, course.last_at) == (5, "h5", "t2")


@pytest.mark.parametrize(
    "reader", [History(), JournalDigest(), Account(), Picture(Path("journal"), None)], ids=type
)
def test_every_reader_of_a_journal_knows_the_same_course(reader):
    records = (STARTED, SENT, ASKED, HOLE, PAUSE, RESUMED, CHANGED, ENDED, SENT)
    plain = after(*records)
    after(*records, course=reader)

    assert [getattr(reader, name) for name in Course.__slots__] == [
        getattr(plain, name) for name in Course.__slots__
    ]
