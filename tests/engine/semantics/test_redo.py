"""Holes that are measured again

`labrun resume RUN --holes` measures every iteration that failed again, `--point KEY` only those that are
named. It is a new pass: its goals have a level of their own in their ids (`main/scan/4,1/pass:2/shoot/1`),
and "`once` is never sent twice" holds within one pass. A named person asks for it; the journal keeps both.

    - foreach: {p: "${{ grid([1 mm, 2 mm], [1 mm]) }}"}
      key: "${{ p.ix }},${{ p.iy }}"
      keep_going: {in_a_row: 3}         # `labrun resume last --point 4,1 --by Ada` measures one hole again
      steps: [{do: gantry.move_to, with: {x: "${{ p.x }}", y: "${{ p.y }}"}}]
"""

from collections import Counter
from random import Random

import pytest

from labrun.engine.check import check_file
from labrun.engine.exit_status import PROBLEMS
from labrun.engine.journal.history import read_history
from labrun.engine.run.summary import summary_of
from labrun.web.report.journal_digest import read_digest
from labrun.web.runs.outline import Outline

from .books import Onlooker, everywhere

LOOP = """
steps:
  - {do: c.act, with: {name: focus}}
  - id: all
    foreach: {i: "${{ range(4) }}"}
    keep_going: true
    steps:
      - {do: b.act, with: {name: "move${{ i }}"}}
      - {id: x, do: a.shoot, with: {name: "x${{ i }}", script: "${{ 'Half,ok' if i in [1, 2] else 'ok' }}"}}
    collect: {i: "${{ i }}", n: "${{ steps.x.n }}"}
  - {do: c.act, with: {name: after}}
on_resume: [{do: c.act, with: {name: home}}]
finally: [{do: c.act, with: {name: tidy}}]
"""
FIRST = ["focus", "move0", "x0", "move1", "x1", "move2", "x2", "move3", "x3", "after", "tidy"]
NESTED = """
steps:
  - id: cores
    foreach: {core: [A, B]}
    key: "${{ core }}"
    steps:
      - {id: mount, do: b.pulse, with: {name: "mount${{ core }}"}}
      - {do: b.act, with: {name: "light${{ core }}"}}
      - id: scan
        foreach: {i: [0, 1]}
        keep_going: true
        steps:
          - id: x
            do: a.shoot
            with: {name: "${{ core }}${{ i }}", script: "${{ 'Half,ok' if i == 1 else 'ok' }}"}
        collect: {n: "${{ steps.x.n }}"}
"""
END = """      - do: c.act
        with: {name: "end${{ core }}", script: "${{ 'Broken,ok' if core == 'A' else 'ok' }}"}
"""


def shots(ran):
    return [r.id.partition("/")[2] for r in ran.records if r.kind == "goal" and r.action == "shoot"]


def test_all_holes(bench):
    """A run with holes is resumed with `--holes` -> `on_resume`; the settings before the loop are made
    again, then every iteration that failed from its first step; `finally`. No other iteration is
    entered."""
    bench.run(LOOP)

    ran = bench.resume(holes=True)

    assert ran.status == 0
    assert ran.sent[len(FIRST) :] == [
        "home", "focus", "move1", "x1", "move2", "x2", "after", "tidy",
    ]  # fmt: skip
    assert ran.finished.holes == 0
    assert ran.finished.points.model_dump() == {"plan": 4, "measured": 4, "failed": 0, "left": 0}


def test_the_point_at_which_the_run_failed(bench):
    """No `keep_going`: the run failed at a shot that had happened -> A plain resume fails there again,
    and sends no shot; its last lines say so. It has failed, in every list and report alike. `--holes`
    measures that iteration again, and the run goes on."""
    bench.run(LOOP.replace("keep_going: true", "").replace("[1, 2]", "[1]"))
    plain = bench.resume()
    told = everywhere(plain.folder)

    ran = bench.resume(holes=True)

    assert (plain.status, plain.sent.count("x1")) == (1, 1)
    assert set(told.values()) == {(4, 1, 1, 2, 1)}, told
    assert (ran.status, ran.sent.count("x1")) == (0, 2)
    assert shots(ran)[-3:] == ["main/all/1/pass:2/x/1", "main/all/2/x/1", "main/all/3/x/1"]
    assert ran.finished.points.model_dump() == {"plan": 4, "measured": 4, "failed": 0, "left": 0}


def test_the_shot_at_which_the_run_failed(bench):
    """As before, at a shot outside any loop -> A plain resume fails there again. `--holes` sends that shot
    anew and no other, as often as it is asked for, and the run goes on."""
    steps = """
steps:
  - {id: first, do: a.shoot, with: {name: x0}}
  - id: group
    retry: 2
    steps: [{id: x, do: a.shoot, with: {name: x1, script: "Half,Half,ok"}}]
  - {do: b.act, with: {name: after}}
"""
    first, plain = bench.run(steps), bench.resume()
    again = bench.resume(holes=True)

    ran = bench.resume(point=["group/x"])

    assert [first.status, plain.status, again.status, ran.status] == [1, 1, 1, 0]
    assert [one.holes for one in ran.records if one.kind == "finished"] == [1, 1, 1, 0]
    assert ran.sent == ["x0", "x1", "x1", "x1", "after"]
    assert shots(ran)[1:] == [f"main/group/x{level}/1" for level in ("", "/pass:2", "/pass:3")]


def test_rows_are_replaced(bench):
    """A hole is measured again -> Its row is replaced; the journal has both."""
    bench.run(LOOP)

    ran = bench.resume(holes=True)

    assert sorted((row["key"], row["n"], row["fate"]) for row in ran.rows()) == [
        ("0", "1", "succeeded"), ("1", "2", "succeeded"), ("2", "2", "succeeded"),
        ("3", "1", "succeeded"),
    ]  # fmt: skip
    ended = [r.fate for r in ran.records if r.kind == "iteration" and r.key == "1"]
    assert ended == ["failed", "succeeded"]


def test_ids_have_a_level(bench):
    """The goals of a second pass -> Their ids name it; the journal names the person who asked."""
    bench.run(LOOP)

    ran = bench.resume(holes=True)

    (asked,) = [r for r in ran.records if r.kind == "redo"]
    assert shots(ran)[-2:] == ["main/all/1/pass:2/x/1", "main/all/2/pass:2/x/1"]
    (resumed,) = [r for r in ran.records if r.kind == "resumed"]
    assert (asked.by, asked.iterations) == ("Ada", ["main/all/1", "main/all/2"])
    assert resumed.by == "Ada"


def test_chosen_points(bench):
    """`--point 2` -> Only that hole is measured again; the others stay holes."""
    bench.run(LOOP)

    ran = bench.resume(point=["2"])

    assert ran.status == 0
    assert ran.sent[len(FIRST) :] == ["home", "focus", "move2", "x2", "after", "tidy"]
    assert ran.finished.holes == 1
    assert ran.finished.points.words() == "3 of 4 measured, 1 failed"


def test_aborted_before_its_first_row(bench):
    """Every iteration is measured again, and the run is aborted before the first has ended -> The table
    has its header, and no row yet."""
    bench.run(LOOP.replace("if i in [1, 2]", "if i < 9"))

    ran = bench.resume(holes=True, abort="phase  resume")

    assert (ran.folder / "data.csv").read_text() == "key,i,n,fate\n"
    assert ran.finished.points.words() == "0 of 4 measured, 4 left"


def test_what_is_no_hole_is_refused(bench, capfd):
    """`--point` names no hole -> Nothing is sent; it says which there are."""
    bench.run(LOOP)

    ran = bench.resume(point=["3"])

    assert ran.status == PROBLEMS
    assert ran.sent == FIRST
    assert "no hole '3'; it has 1, 2" in capfd.readouterr().err


def test_no_holes(bench, capfd):
    """A run without holes, `--holes` -> Nothing is sent."""
    bench.run("steps: [{do: a.act, with: {name: x}}]")

    ran = bench.resume(holes=True)

    assert ran.status == PROBLEMS
    assert "has no holes" in capfd.readouterr().err


def test_it_fails_again(bench):
    """It fails again -> It is a hole again, and can be measured in a third pass."""
    bench.run(LOOP.replace("Half,ok", "Half,Half,ok"))
    bench.resume(holes=True)

    ran = bench.resume(holes=True)

    assert shots(ran)[-1] == "main/all/2/pass:3/x/1"
    assert ran.finished.holes == 0
    assert len(ran.rows()) == 4


def test_killed_in_a_second_pass(bench):
    """The engine is killed after the shot of a second pass -> Resume does not send it again, and measures
    the rest of the pass."""
    bench.run(LOOP)
    bench.kill_again("ended main/all/1/pass:2/x", "--holes")

    ran = bench.resume()

    assert ran.status == 0
    assert [name for name in ran.sent if name[0] == "x"] == ["x0", "x1", "x2", "x3", "x1", "x2"]
    assert ran.finished.points.words() == "4 of 4 measured"
    assert sorted(row["key"] for row in ran.rows()) == ["0", "1", "2", "3"]


def test_killed_before_a_second_pass(bench):
    """The engine is killed before the first of them -> They are left, neither measured nor holes; resume
    measures them."""
    bench.run(LOOP)
    killed = bench.kill_again("resumed", "--holes")
    summary = summary_of(killed.folder)

    ran = bench.resume()

    assert (summary.fate, summary.holes) == ("interrupted", 0)
    assert summary.points.words() == "2 of 4 measured, 2 left"
    assert ran.finished.points.words() == "4 of 4 measured"


def test_holes_of_an_inner_loop(bench):
    """The hole is in an inner loop -> The iteration around it is entered again: what it had set is set
    again, its finished `once` actions are not sent."""
    bench.run(NESTED)

    ran = bench.resume(point=["B/1"])

    assert ran.sent[8:] == ["lightB", "B1"]
    assert ran.finished.holes == 1
    assert [(row["key"], row["fate"]) for row in ran.rows()] == [
        ("A/0", "succeeded"), ("A/1", "failed"), ("B/0", "succeeded"), ("B/1", "succeeded"),
    ]  # fmt: skip


def test_a_hole_around_others(bench):
    """An iteration failed as a whole -> It is measured again as a whole, with all that is in it."""
    before = bench.run(
        NESTED.replace(
            "    steps:\n      - {id: m", "    keep_going: true\n    steps:\n      - {id: m"
        )
        + END
    ).finished

    ran = bench.resume(point=["A"])

    assert ran.sent[10:] == ["mountA", "lightA", "A0", "A1", "endA"]
    assert before.holes == 2  # what lies within a hole is none of its own
    assert before.points.words(2) == "1 of 2 measured, 1 failed, 1 hole within"
    assert ran.finished.holes == 1
    assert sorted(row["key"] for row in ran.rows()) == ["A/0", "A/1", "B/0", "B/1"]


def test_the_last_turn_of_a_while(bench):
    """The last turn of a `while` failed, and its condition no longer holds -> That turn is measured
    again nevertheless."""
    bench.run("""
steps:
  - set: {n: 0}
  - while: "${{ n < 2 }}"
    max: 9
    keep_going: true
    steps:
      - set: {n: "${{ n + 1 }}"}
      - {do: a.shoot, with: {name: "x${{ n }}", script: "${{ 'Half,ok' if n == 2 else 'ok' }}"}}
""")

    ran = bench.resume(holes=True)

    assert ran.status == 0
    assert len(ran.sent) == 3
    assert ran.finished.holes == 0


def test_a_failed_run_and_its_holes(bench):
    """A run that failed with holes is resumed with `--holes` -> The holes are measured again, and what
    was left."""
    body = LOOP.replace("Half", "Broken").replace("keep_going: true", "keep_going: {max_failed: 1}")
    bench.run(body)

    ran = bench.resume(holes=True)

    assert [name for name in ran.sent if name[0] == "x"] == ["x0", "x1", "x2", "x1", "x2", "x3"]
    assert ran.finished.points.words() == "4 of 4 measured"


def test_the_report_knows(bench):
    """Every hole has been measured -> The report has no hole."""
    bench.run(LOOP)

    ran = bench.resume(holes=True)

    assert read_digest(ran.folder).hole_count == 0


def test_nothing_succeeded_and_resume(bench, capfd):
    """No iteration succeeded, and the run is resumed without `--holes` -> Nothing is sent: it says that
    `--holes` measures them again, and so did the run at its end."""
    bench.run(LOOP.replace("if i in [1, 2]", "if i < 9"))

    ran = bench.resume()

    assert ran.status == PROBLEMS
    assert "`labrun resume" in capfd.readouterr().err
    assert ran.records[-1].kind == "finished"
    assert bench.resume(holes=True).finished.points.words() == "4 of 4 measured"


MAP = """
steps:
  - {{do: c.act, with: {{name: focus}}}}
  - id: all
    foreach: {{i: "${{{{ range(9) }}}}"}}
    keep_going: true
    steps:
      - {{do: b.act, with: {{name: "move${{{{ i }}}}"}}}}
      - id: x
        do: a.shoot
        with: {{name: "x${{{{ i }}}}", seconds: 0.02, script: "${{{{ {scripts}[i] }}}}"}}
    collect: {{i: "${{{{ i }}}}", n: "${{{{ steps.x.n }}}}"}}
on_resume: [{{do: c.act, with: {{name: home}}}}]
finally: [{{do: c.act, with: {{name: tidy}}}}]
"""
ENDS = ("ok", "ok", "ok", "ok", "ok", "Half,ok", "Broken,ok", "Half,Half,ok")
WAYS = ("kill", "kill", "abort", "pause", "stop")
LIVES = 6
PAUSED = "control pause|phase  finally"
"""A stop that comes after the last point pauses nothing."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_at_random(bench, seed):
    """A map is stopped, paused, aborted, killed, resumed and measured again at random -> Plan = measured +
    failed + left, in journal, CLI, API, page and report alike; no shot twice in a pass."""
    dice = Random(seed)
    body = MAP.format(scripts=[dice.choice(ENDS) for _ in range(9)])
    ran = live(bench, dice, {"body": body}, list(range(9)))
    checked = check_file(ran.folder / "protocol.yaml", lab=ran.folder / "lab.yaml")
    onlooker = Onlooker(ran.folder, Outline(checked))
    for _ in range(LIVES):
        holes = check_books(ran, onlooker)
        begun = {record.id.partition("/")[2] for record in ran.records if record.kind == "goal"}
        left = [i for i in range(9) if not any(f"main/all/{i}/" in path for path in begun)]
        again = dice.sample(holes, dice.randint(1, len(holes))) if holes else []
        if not left and not again:
            break
        ran = live(bench, dice, {"again": again}, left + again)
    bench.resume()
    ran = bench.resume(holes=True)
    check_books(ran, onlooker)

    assert ran.finished.points.left == 0


def live(bench, dice, how, moments):
    """One life of an engine: to its end, or until something comes at one of the points."""
    way = dice.choice(WAYS)
    at = f"main/all/{dice.choice(moments)}/(pass:.*/)?x"
    again = how.get("again", [])
    if way == "kill":
        moment = f"{dice.choice(['goal', 'feedback', 'ended'])} {at}"
        options = [word for i in again for word in ("--point", str(i))]
        return (
            bench.kill(how["body"], moment) if "body" in how else bench.kill_again(moment, *options)
        )
    steers = {way: f"feedback .* {at}"} | ({"go_on": PAUSED} if way == "stop" else {})
    if "body" in how:
        return bench.run(how["body"], **steers)
    return bench.resume(point=[str(i) for i in again], **steers)


def check_books(ran, onlooker):
    """The same numbers everywhere, the devices' truth beside them; returns the holes."""
    told = everywhere(ran.folder)
    plan, measured, failed, left, _ = told["journal"]
    assert set(told.values()) == {told["journal"]}, told
    assert onlooker.sees() == told["journal"]
    assert plan == 9 == measured + failed + left
    history = read_history(ran.records)
    fates = {int(key): fate for key, fate in history.past.iterations.get("main/all", {}).items()}
    if ran.records[-1].kind == "finished":
        # Of a run that ended before its first row there is no table.
        rows = ran.rows() if fates or (ran.folder / "data.csv").exists() else []
        assert {int(row["key"]): row["fate"] for row in rows} == fates
        assert len(rows) == len(fates)
    fired = [c for c in ran.calls if c["action"] == "shoot"]
    happened = Counter(c["goal"].rpartition("/")[0] for c in fired if c["word"] in ("done", "Half"))
    assert set(happened.values()) <= {1}  # once in each pass
    done = {int(c["goal"].split("/")[2]) for c in fired if c["word"] == "done"}
    assert {i for i, fate in fates.items() if fate == "succeeded"} <= done
    return sorted(i for i, fate in fates.items() if fate == "failed")
