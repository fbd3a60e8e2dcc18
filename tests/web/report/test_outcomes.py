"""What is said of each failure, by journals that tell every way in which one can be handled."""

from labrun.schemas import journal as j
from labrun.web.report.journal_digest import read_digest

SHOOT = "main/scan/0,0/shoot"


def failures(folder, **how):
    return list(read_digest(folder, **how).outcomes.failures)


def doubts(folder, **how):
    return list(read_digest(folder, **how).outcomes.doubts)


def test_a_retry_that_succeeds_is_told_with_the_attempt(folder, teller):
    teller.started().failed(SHOOT).worked(SHOOT, attempt=2).finished()

    (group,) = failures(folder)
    assert group.first.path == SHOOT
    assert group.first.followed == ["sent again as attempt 2, which succeeded"]
    assert doubts(folder) == []


def test_each_failed_attempt_says_what_became_of_the_next(folder, teller):
    teller.started().failed(SHOOT).failed(SHOOT, attempt=2).worked(SHOOT, attempt=3).finished()

    assert [group.first.followed for group in failures(folder)] == [
        ["sent again as attempt 2, which failed too"],
        ["sent again as attempt 3, which succeeded"],
    ]


def test_a_failure_that_leaves_an_iteration_out_is_a_hole(folder, teller):
    message = f"{SHOOT}: libs.measure: NoSignal: no such luck"
    teller.started().failed(SHOOT, "NoSignal", happened="yes")
    teller.iteration("0,0", "failed", message=message).finished(holes=1)

    (group,) = failures(folder)
    assert group.first.happened == "yes"
    assert group.first.followed == ["the iteration was left out: a hole"]


def test_a_failure_that_may_be_ignored_does_not_keep_its_iteration_from_succeeding(folder, teller):
    teller.started().failed(SHOOT).iteration("0,0").finished()

    (group,) = failures(folder)
    assert group.first.followed == ["the iteration continued and succeeded"]


def test_a_failure_beside_the_one_that_made_the_hole_is_not_blamed_for_it(folder, teller):
    teller.started().failed("main/scan/0,0/analyse", action="reduce.reduce", effect="pure")
    teller.failed(SHOOT).iteration(
        "0,0", "failed", message=f"{SHOOT}: libs.measure: X: y"
    ).finished()

    followed = {group.first.path: group.first.followed for group in failures(folder)}
    assert followed[SHOOT] == ["the iteration was left out: a hole"]
    assert followed["main/scan/0,0/analyse"] == [
        "the iteration continued, and was left out for another reason: a hole"
    ]


def test_a_probe_that_found_the_shot_settles_the_doubt(folder, teller):
    teller.started().failed(SHOOT, "DialogOpen", happened="unknown")
    told = {"shot_id": "s1", "goal_id": f"2026-11-21_test_0001/{SHOOT}/1"}
    teller.worked(f"{SHOOT}/1/probe", "libs.last_shot", result=told).iteration("0,0").finished()

    (group,) = doubts(folder)
    said = [
        "the probe last_shot reported that it had happened; its result was taken from the probe"
    ]
    assert group.first.followed == said
    assert failures(folder)[0].first.followed == said


def test_a_probe_that_found_another_shot_lets_the_retry_go_on(folder, teller):
    teller.started().failed(SHOOT, "DialogOpen", happened="unknown")
    teller.worked(f"{SHOOT}/1/probe", "libs.last_shot", result={"goal_id": "other/1"})
    teller.worked(SHOOT, attempt=2).iteration("0,0").finished()

    assert doubts(folder)[0].first.followed == [
        "the probe last_shot reported that it had not happened",
        "sent again as attempt 2, which succeeded",
    ]


def test_where_the_probe_cannot_say_the_person_who_decided_is_named(folder, teller):
    teller.started().failed(SHOOT, "DialogOpen", happened="unknown")
    teller.worked(f"{SHOOT}/1/probe", "libs.last_shot", result={"goal_id": None})
    path = f"{SHOOT}/1/unknown"
    teller.tell(j.Asked(path=path, id="shoot", text="Did it?", choices=["repeat", "skip"]))
    teller.tell(j.Answered(path=path, choice="skip", by="the page"))
    teller.iteration("0,0", "failed", message=f"{SHOOT}: libs.measure: DialogOpen: x").finished()

    assert doubts(folder)[0].first.followed == [
        "the probe last_shot could not determine it",
        "the operator was asked",
        "the page answered 'skip'",
        "the iteration was left out: a hole",
    ]


def test_fallbacks_and_their_question_are_told_of_the_step_that_they_stand_in_for(folder, teller):
    error = {"name": "ButtonNotFound", "message": "m", "step": SHOOT}
    teller.started().failed(SHOOT)
    teller.tell(j.Turned(path=f"{SHOOT}/f", turn=1, error=error))
    teller.failed(f"{SHOOT}/f1/0", action="libs.reconnect", effect="idempotent")
    teller.tell(j.Turned(path=f"{SHOOT}/f", turn=2, error=error | {"step": f"{SHOOT}/f1/0"}))
    path = f"{SHOOT}/f2/ask"
    teller.tell(j.Asked(path=path, id="shoot", text="What now?", choices=["repeat", "skip"]))
    teller.tell(j.Answered(path=path, choice="repeat", by="another shell"))
    teller.tell(j.Turned(path=f"{SHOOT}/a", turn=2)).worked(f"{SHOOT}/a2/shoot").iteration("0,0")
    teller.finished()

    followed = {group.first.path: group.first.followed for group in failures(folder)}
    assert followed[SHOOT] == [
        "fallback 1 was tried",
        "fallback 2 was tried",
        "the operator was asked",
        "another shell answered 'repeat'",
        "repeated from its beginning, as the operator chose",
        "the iteration continued and succeeded",
    ]


def test_a_group_that_is_begun_again_is_told_of_the_step_that_failed(folder, teller):
    error = {"name": "X", "message": "m", "step": "main/group/shoot"}
    teller.started().failed("main/group/shoot")
    teller.tell(j.Turned(path="main/group/r", turn=2, error=error))
    teller.worked("main/group/r2/shoot").finished()

    (group,) = failures(folder)
    assert group.first.followed == [
        "the group around it was restarted, turn 2",
        "the run continued",
    ]


def test_the_failure_that_ended_the_run_is_named(folder, teller):
    teller.started().failed("main/shoot")
    teller.finished(
        "failed",
        reason="step shoot: libs.measure: no such luck",
        detail="main/shoot: libs.measure: ButtonNotFound: no such luck",
    )

    (group,) = failures(folder)
    assert group.first.followed == ["the run failed because of it"]


def test_what_was_under_way_when_the_engine_was_killed_is_settled_by_its_server(folder, teller):
    teller.started().sent(SHOOT).after(60).tell(j.Resumed(count=1, labrun="0.1.0"))
    teller.ended(SHOOT, result={"shot_id": "s1"}).iteration("0,0").finished()

    (group,) = doubts(folder)
    assert group.first.doubt == "under way when engine 1 ended"
    assert group.first.followed == ["after the resume its server reported that it had succeeded"]
    assert failures(folder) == []


def test_what_its_server_lost_too_is_told_and_sent_again_after_the_resume(folder, teller):
    teller.started().sent("main/lift", "gantry.move_to", effect="idempotent")
    teller.after(60).tell(j.Resumed(count=1, labrun="0.1.0"))
    teller.ended("main/lift", error="Lost", happened="unknown")
    teller.worked("main/lift", "gantry.move_to", attempt=2, effect="idempotent").finished()

    assert doubts(folder)[0].first.followed == [
        "after the resume its server reported that it was lost: it is unknown whether it had happened"
    ]
    (group,) = failures(folder)
    said = "sent again after the run was resumed as attempt 2, which succeeded"
    assert group.first.followed == [said]


def test_a_run_without_an_end_says_which_goals_nobody_knows_about(folder, teller):
    teller.started().sent(SHOOT)

    (group,) = doubts(folder)
    assert group.first.followed == ["not resolved; `labrun resume` asks its server"]
    assert doubts(folder, live=True) == []


def test_a_goal_whose_server_stayed_away_while_the_run_went_on_is_lost_not_forgotten(
    folder, teller
):
    teller.started().sent(SHOOT)
    message = f"{SHOOT}: libs.measure: Lost: out of reach"
    teller.iteration("0,0", "failed", message=message).finished()

    (group,) = failures(folder)
    assert group.first.error == "Lost"
    assert group.first.followed == ["the iteration was left out: a hole"]
    assert len(doubts(folder)) == 1


def test_a_goal_that_was_cancelled_past_its_timeout_is_a_timeout(folder, teller):
    teller.started().sent("main/lift", "gantry.move_to", timeout_s=5).after(5)
    teller.ended("main/lift", state="CANCELED").finished()

    (group,) = failures(folder)
    assert (group.first.error, group.first.failed) == ("Timeout", True)
    assert "its timeout is 5.0 s" in group.first.message


def test_what_an_abort_cancelled_is_no_failure_and_says_who_aborted(folder, teller):
    teller.started().sent("main/lift", "gantry.move_to").tell(j.Control(verb="abort", by="Ctrl-C"))
    teller.ended("main/lift", state="CANCELED").finished("aborted", reason="aborted by Ctrl-C")

    (group,) = failures(folder)
    assert not group.first.failed
    assert group.first.followed == ["cancelled because the run was aborted by Ctrl-C"]


def test_many_that_are_alike_are_one_group_whatever_the_numbers_in_their_words(folder, teller):
    teller.started()
    for i in range(30):
        path = f"main/scan/{i}/shoot"
        teller.failed(path, message=f"button at {i}.5, 7 not found").worked(path, attempt=2)
        teller.iteration(str(i))
    teller.finished()

    found = read_digest(folder).outcomes.failures
    (group,) = found
    assert group.count == 30
    assert len(group.examples) == 8
    assert found.outcomes() == {"succeeded when sent again": 30}


def test_nothing_of_finished_iterations_is_kept(folder, teller):
    teller.started()
    for i in range(50):
        teller.failed(f"main/scan/{i}/shoot").iteration(str(i))

    outcomes = read_digest(folder).outcomes
    assert not outcomes.latest
    assert not outcomes.fallbacks
    assert not outcomes.course.under_way
