"""A live run is changed

`labrun change RUN FILE` shows what a changed protocol would mean for the work that is done, asks, and lets a
live run go on with it, as `labrun resume --changed FILE` does to one that was stopped. What runs ends first;
nothing new begins until the change is in the journal.

    - foreach: {i: "${{ range(5) }}"}   # it was range(3): `labrun change last map.yaml`, while it is running
      steps: [{do: gantry.move_to, with: {x: "${{ i * 1 mm }}"}}, {id: shoot, do: libs.measure}]
"""

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
