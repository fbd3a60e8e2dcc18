"""A journal is read into counts, times, questions and lives, also when it is damaged."""

import pytest

from labrun.schemas import journal as j
from labrun.web.report.journal_digest import interruptions, read_digest


def test_actions_are_counted_by_how_they_ended_and_how_long_they_took(folder, teller):
    teller.started().worked("main/a").failed("main/b").worked("main/b", attempt=2).sent("main/c")
    teller.after(2).ended("main/c", state="CANCELED").sent("main/d").finished()

    deed = read_digest(folder).deeds["libs.measure"]
    assert (deed.sent, deed.succeeded, deed.failed, deed.cancelled, deed.again) == (5, 2, 1, 1, 1)
    assert deed.sent - deed.ended == 1
    assert deed.longest_s == pytest.approx(2.01)


def test_the_time_for_which_no_engine_ran_is_not_counted_as_an_actions_own(folder, teller):
    teller.started().sent("main/a").after(3600).tell(j.Resumed(count=1, labrun="0.1.0"))
    teller.ended("main/a").worked("main/b").finished()

    deed = read_digest(folder).deeds["libs.measure"]
    assert (deed.ended, deed.timed) == (2, 1)
    assert deed.mean_s == deed.longest_s == pytest.approx(0.01)


def test_loops_inside_a_loop_are_counted_as_one(folder, teller):
    teller.started()
    for outer in range(3):
        for inner in range(4):
            teller.iteration(
                str(inner), "failed" if inner == 1 else "succeeded", f"main/a/{outer}/b"
            )
        teller.iteration(str(outer), loop="main/a")
    teller.finished()

    loops = read_digest(folder).loops
    assert {name: (n.total, n.failed) for name, n in loops.items()} == {
        "main/a": (3, 0), "main/a/*/b": (12, 3),
    }  # fmt: skip


def test_holes_of_one_reason_are_put_together_with_their_places(folder, teller):
    teller.started()
    for i in range(5):
        message = f"main/scan/{i}/shoot: libs.measure: NoSignal: dark"
        teller.iteration(str(i), "failed", message=message)

    (holes,) = read_digest(folder).holes.values()
    assert holes.message == "shoot: libs.measure: NoSignal: dark"
    assert holes.places == [f"main/scan/{i}" for i in range(5)]


def test_lives_interruptions_and_pauses_have_their_lengths(folder, teller):
    teller.started().tell(j.Control(verb="pause", by="the page"))
    teller.after(30).tell(j.Control(verb="continue", by="another shell")).sent("main/a")
    teller.after(600).tell(j.Resumed(count=1, labrun="0.2.0", torn=17)).ended("main/a").finished()

    digest = read_digest(folder)
    ((first, second),) = interruptions(digest)
    assert (first.under_way, second.labrun, second.torn) == (1, "0.2.0", 17)
    assert digest.spans.away_s == pytest.approx(600.01)
    assert digest.spans.paused_s == pytest.approx(30.01)
    assert digest.spans.holds[0].ended_by == "continue by another shell"


def test_a_clock_that_is_set_back_shortens_no_session_and_is_told(folder, teller):
    teller.started().after(60).sent("main/a").after(-3600).ended("main/a").after(30).sent("main/b")
    teller.after(-7200).tell(j.Resumed(count=1, labrun="0.2.0")).ended("main/b").finished()

    spans = read_digest(folder).spans
    assert spans.lives[0].seconds == pytest.approx(90, abs=0.1)
    assert spans.set_back_s == pytest.approx(3600 + 7200, abs=0.1)


def test_the_time_before_holes_are_measured_again_is_without_an_engine(folder, teller):
    teller.started().worked("main/a").finished().after(600)
    teller.tell(j.Redo(by="Ada", pass_number=2, iterations=["main/scan/3"]))
    teller.tell(j.Resumed(count=1, labrun="0.1.0")).worked("main/b").finished()

    assert read_digest(folder).spans.away_s == pytest.approx(600.02)


def test_a_pause_ends_with_its_engine(folder, teller):
    teller.started().tell(j.Control(verb="pause", by="the page")).after(5).sent("main/a")
    teller.after(100).tell(j.Resumed(count=1, labrun="0.1.0"))

    (hold,) = read_digest(folder).spans.holds
    assert hold.ended_by == "the end of its engine"
    assert read_digest(folder).spans.paused_s == pytest.approx(5.01)


def test_a_question_that_nobody_answered_stays_open(folder, teller):
    teller.started().tell(j.Asked(path="main/q", id="q", text="Well?", choices=["yes", "no"]))

    (asking,) = read_digest(folder).asked
    assert (asking.text, asking.choice) == ("Well?", "")


def test_a_torn_last_line_is_left_out(folder, teller):
    teller.started().worked("main/a")
    with teller.path.open("a", newline="\n") as file:
        file.write('{"n":5,"at":"2026-11-2')

    digest = read_digest(folder)
    assert digest.last_n == 4
    assert digest.damage == ""


def test_a_journal_that_was_changed_is_told_as_far_as_it_can_be_trusted(folder, teller):
    teller.started().worked("main/a").finished()
    lines = teller.path.read_text().splitlines(keepends=True)
    lines[3] = lines[3].replace("SUCCEEDED", "ABORTED")
    teller.path.write_text("".join(lines), newline="\n")

    digest = read_digest(folder)
    assert digest.last_n == 3
    assert "breaks at record 4" in digest.damage


def test_a_journal_with_bytes_that_are_no_text_is_told_up_to_there(folder, teller):
    teller.started()
    with teller.path.open("ab") as file:
        file.write(b'{"n":3,"text":"\xff\xfe","hash":"0"}\n')

    digest = read_digest(folder)
    assert digest.last_n == 2
    assert "record 3" in digest.damage


def test_an_empty_journal_is_a_story_without_a_beginning(folder, teller):
    teller.path.touch()

    digest = read_digest(folder)
    assert (digest.last_n, digest.began, digest.started) == (0, "", None)


def test_a_run_that_was_taken_up_again_has_the_end_of_its_last_life(folder, teller):
    teller.started().finished("failed", reason="no").tell(j.Resumed(count=1, labrun="0.1.0"))

    digest = read_digest(folder)
    assert digest.finished is None
    assert [life.fate for life in digest.spans.lives] == ["failed", ""]


def test_iterations_that_are_done_again_after_a_change_count_once(folder, teller):
    teller.started().iteration("0").iteration("1", "failed", message="dark")
    teller.finished("failed").tell(j.Resumed(count=1, labrun="0.1.0"))
    teller.tell(j.Changed(folder="changed/1", reopened=["main/scan/0", "main/scan/1"]))
    teller.iteration("0").iteration("1").finished()

    digest = read_digest(folder)
    assert (digest.loops["main/scan"].succeeded, digest.loops["main/scan"].failed) == (2, 0)
    assert digest.hole_count == 0
    assert [change.folder for change in digest.changes] == ["changed/1"]
