"""A live run is changed

`labrun change RUN FILE` shows what a changed protocol would mean for the work that is done, asks, and lets a
live run go on with it, as `labrun resume --changed FILE` does to one that was stopped. What runs ends first;
nothing new begins until the change is in the journal.

    - foreach: {i: "${{ range(5) }}"}   # it was range(3): `labrun change last map.yaml`, while it is running
      steps: [{do: gantry.move_to, with: {x: "${{ i * 1 mm }}"}}, {id: shoot, do: libs.measure}]
"""

# ruff: noqa: E501 - a protocol has a line for each step
import pytest

GATE = "  - {id: gate, ask: on?, choices: [go]}\n"
STEPS = """
steps:
  - id: scan
    foreach: {i: "${{ range(N) }}"}
    steps:
      - {id: move, do: b.act, with: {name: "move${{ i }}", seconds: 0.1}}
      - {do: a.shoot, with: {name: "x${{ i }}"}}
    collect: {i: "${{ i }}"}
  - {do: c.act, with: {name: LAST}}
finally: [{do: c.act, with: {name: tidy}}]
"""


def steps(n, last="after", gate=GATE, more=("", "")):
    text = STEPS.replace("N)", f"{n})").replace("LAST", last).replace(*more)
    return text.replace("finally:", gate + "finally:")


SHOTS = {n: [part for i in range(n) for part in (f"move{i}", f"x{i}")] for n in (3, 5)}
AT = "goal sent main/scan/1/move"
EXTRA = "      - {do: c.act, with: {name: extra}}\n"
BEHIND = ('name: "x${{ i }}"}}\n', 'name: "x${{ i }}"}}\n' + EXTRA)
BEFORE = ("seconds: 0.1}}\n", "seconds: 0.1}}\n" + EXTRA)
WAIT = ("seconds: 0.1}}\n", "seconds: 0.1}}\n      - {wait: 0 s}\n")


@pytest.fixture
def changed(bench):
    """A run that is changed while it moves to its second point; a question at its end keeps it alive."""

    def run(body, first=None):
        ran = bench.run(
            first or steps(3), change=(AT, body), answer=("question open main/gate", "go")
        )
        (answer,) = [said for said in ran.said if isinstance(said, tuple)]
        return ran, answer

    return run


def test_more_points(changed):
    """A list gets more items while an action runs -> The action ends, then the change counts: what was done
    is done, and the run goes on by itself."""
    ran, (ok, text) = changed(steps(5, "later"))

    assert ok, text
    assert ran.sent == [*SHOTS[5], "later", "tidy"]
    assert [row["i"] for row in ran.rows()] == list("01234")
    kinds = [r.kind for r in ran.records]
    moved = next(r.n for r in ran.records if r.kind == "ended" and "/1/move/" in r.id)
    assert kinds.index("changed") >= moved
    assert [r.verb for r in ran.records if r.kind == "control"] == ["pause", "continue"]


def test_new_steps_in_finished_points(changed):
    """It has a new step in its loop -> Finished iterations are entered again for that step alone."""
    ran, (ok, _) = changed(steps(3, more=BEHIND))

    assert ok
    assert [n for n in ran.sent if n[0] == "x"] == ["x0", "x1", "x2"]
    assert ran.sent.count("extra") == 3
    assert sorted(row["i"] for row in ran.rows()) == ["0", "1", "2"]


def test_a_shot_that_is_done_would_differ(changed):
    """A `once` action that is done would differ -> It is refused in words, and the run goes on as it was."""
    ran, (ok, text) = changed(steps(3, more=('name: "x$', 'name: "y$')))

    assert not ok
    assert "x0 -> y0 at main/scan/0/1: it was done already" in text
    assert ran.sent == [*SHOTS[3], "after", "tidy"]
    assert not [r for r in ran.records if r.kind == "changed"]


@pytest.mark.parametrize("more", [BEFORE, WAIT])
def test_a_shot_that_is_done_would_have_another_place(changed, more):
    """A step is put before a `once` action without an `id` that is done -> It is refused: by its
    new place, it would be done twice."""
    ran, (ok, text) = changed(steps(3, more=more))

    assert not ok
    assert "Steps without an `id` are known by their place" in text
    assert [n for n in ran.sent if n[0] == "x"] == ["x0", "x1", "x2"]


def test_it_has_problems(changed):
    """It has a problem -> It is refused with the line, and the run goes on as it was."""
    ran, (ok, text) = changed(steps(3).replace("c.act", "c.akt"))

    assert not ok
    assert "did you mean act" in text
    assert ran.sent == [*SHOTS[3], "after", "tidy"]


def test_it_was_paused(bench):
    """It was paused by a person -> It stays paused; after `labrun continue` it goes on with the change."""
    ran = bench.run(steps(5, gate=""), pause=AT, change=(AT, steps(3, "later", gate="")))

    assert ran.sent == [*SHOTS[3], "later", "tidy"]
    assert [r.verb for r in ran.records if r.kind == "control"] == ["pause", "continue"]


@pytest.mark.parametrize(
    ("moment", "last"), [("^control", "after"), ("copies", "after"), ("^changed", "later")]
)
def test_killed_around_it(bench, moment, last):
    """The engine is killed before or after the record of the change -> Resume goes on with the old
    protocol, or with the new one, as a whole; no `once` action is sent twice."""
    new = steps(5, "later", gate="")
    bench.kill(steps(3, gate=""), moment, change=(AT, new))

    ran = bench.resume()

    assert ran.status == 0
    assert [n for n in ran.sent if n[0] == "x"] == SHOTS[3 if last == "after" else 5][1::2]
    assert last in ran.sent and not {"after", "later"} - {last} & set(ran.sent)


@pytest.mark.slow
def test_changed_again_and_killed(bench):
    """A change that was kept and never counted, then another -> What counts is the newest in the journal."""
    bench.kill(steps(3, gate=""), "copies", change=(AT, steps(5, "never", gate="")))
    ran = bench.resume(change=("goal sent main/scan/2/move", steps(5, "later", gate="")))

    assert [r.folder for r in ran.records if r.kind == "changed"] == ["changes/1"]
    assert ran.sent[-2:] == ["later", "tidy"]
    assert [n for n in ran.sent if n[0] == "x"] == SHOTS[5][1::2]


PLATE = """
steps:
  - id: plate
    foreach: {i: [0, 1, 2]}
    at_once: 2
    keep_going: true
    steps:
      - reserve: [a, b]
        steps: [{do: b.act, with: {name: "to${{ i }}"}}, {id: x, do: a.shoot, with: {name: "x${{ i }}", script: "SCRIPT"}}]
      - {do: c.act, with: {name: "weigh${{ i }}"}}
    collect: {i: "${{ i }}"}
  - {id: end, do: c.act, with: {name: last, script: LAST}}
"""
ASIDE = """
steps:
  - {id: heat, mode: background, steps: [{id: load, do: b.pulse, with: {name: load}}, {id: ramp, do: b.act, with: {name: RAMP}}]}
  - {id: x, do: a.shoot, with: {name: x}}
  - {id: end, do: c.act, with: {name: last, script: LAST}}
"""
WATCHED = """
steps:
  - id: g
    watch: [SECOND{when: "${{ status.a.level > -1000 mm }}", then: [{id: t, do: a.pulse, with: {name: instead}}]}]
    steps: [{id: x, do: a.shoot, with: {name: never}}]
  - {id: end, do: c.act, with: {name: last, script: LAST}}
"""


def failing(body, *changes):
    """The protocol whose last step fails, and the one in which that is mended, and more."""
    first = body.replace("RAMP", "ramp").replace("SECOND", "").replace("LAST", "Broken")
    second = body.replace("LAST", "ok").replace("SCRIPT", "ok")
    for old, new in changes:
        assert old in second
        second = second.replace(old, new)
    return first.replace("SCRIPT", "ok"), second.replace("RAMP", "ramp").replace("SECOND", "")


def test_iterations_at_once(bench):
    """A stopped run with iterations at once and reserved devices gets an item -> That alone is done."""
    first, second = failing(PLATE, ("[0, 1, 2]", "[0, 1, 2, 3]"))
    before = bench.run(first)

    ran = bench.resume(changed=second)

    assert (before.status, ran.status) == (1, 0)
    assert ran.sent[len(before.sent) :] == ["to3", "x3", "weigh3", "last"]
    assert [row["i"] for row in ran.rows()] == ["0", "1", "2", "3"]


def test_a_reserved_move_would_go_elsewhere(bench):
    """A move before a shot in a reserved group would differ -> It is refused unless a person keeps the shots."""
    first, second = failing(PLATE, ('"to${{ i }}"', '"there${{ i }}"'))
    before = bench.run(first)
    refused = bench.resume(changed=second)
    ran = bench.resume(changed=second, yes=True)

    assert (refused.status, refused.sent) == (2, before.sent)
    assert ran.status == 0
    assert sorted(n for n in ran.sent if n[0] == "x") == ["x0", "x1", "x2"]
    assert len(ran.rows()) == 3


def test_a_group_in_the_background(bench):
    """A step of a background group would differ -> It is done again, and no `once` action of the group."""
    first, second = failing(ASIDE, ("RAMP", "higher"))
    before = bench.run(first)

    ran = bench.resume(changed=second, yes=True)

    assert ran.status == 0
    assert sorted(ran.sent[len(before.sent) :]) == ["higher", "last"]


SECOND = '{when: "${{ status.b.level > 1000 mm }}", then: {fail: too high}}, '


def test_a_watch_before_one_that_was_right(bench):
    """A watch is put before one that was right -> It is refused: its `then` has no place any more."""
    first, second = failing(WATCHED, ("SECOND", SECOND))
    before = bench.run(first)

    ran = bench.resume(changed=second)

    assert before.sent == ["instead", "last"]
    assert (ran.status, ran.sent) == (2, before.sent)


def test_another_watch_behind_it(bench):
    """A watch is put behind one that was right -> What was right stays so, and nothing is done twice."""
    first, second = failing(WATCHED)
    before = bench.run(first)

    ran = bench.resume(changed=second.replace("}]}]", "}]}, " + SECOND.removesuffix(", ") + "]"))

    assert (before.status, ran.status) == (1, 0)
    assert ran.sent == ["instead", "last", "last"]


def test_holes_at_once(bench):
    """Iterations at once left a hole -> `--holes` enters that one alone; its devices are reserved for it."""
    body = PLATE.replace("LAST", "ok").replace("SCRIPT", "${{ 'Half,ok' if i == 1 else 'ok' }}")
    before = bench.run(body)
    holes = before.finished.holes

    ran = bench.resume(holes=True)

    assert (holes, ran.status, ran.finished.holes) == (1, 0, 0)
    assert ran.sent[len(before.sent) :] == ["to1", "x1", "weigh1", "last"]
    assert sorted(row["i"] for row in ran.rows()) == ["0", "1", "2"]


FLOOD = """
steps:
  - id: scan
    foreach: {i: [0, 1]}
    keep_going: true
    steps:
      - {id: r, do: b.act, with: {name: "r${{ i }}"}}
      - watch: [{every: 50 ms, when: "${{ steps.r.n < 2 and i == 0 }}", then: {fail: high}}]
        steps: [{do: a.shoot, with: {name: "x${{ i }}"}}]
"""


def test_a_hole_that_a_watch_has_made(bench):
    """A watch made an iteration fail -> `--holes` watches it anew; if it is right no more, the steps are done."""
    before = bench.run(FLOOD)
    holes = before.finished.holes

    ran = bench.resume(holes=True)

    assert (holes, before.sent) == (1, ["r0", "r1", "x1"])
    assert (ran.status, ran.finished.holes) == (0, 0)
    assert ran.sent[3:] == ["r0", "x0"]
