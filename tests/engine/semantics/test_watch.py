"""`watch`: what is looked at while steps run

A group may be watched while its steps run. Where a condition holds, its running actions are cancelled
and have ended; then `then` runs in place of the steps and decides: `fail`, or other steps after which the run
goes on. `then: pause`, and a `then` that only tells (`notify`, `log`), leave the steps running, and
come once each time that the condition begins to hold. `status.ROLE.FIELD` is what a device tells of itself; with
`do`, a watch reads a device every so often. **A dead sensor is no safety**: what nobody has known for longer
than `stale` (three times `every`, at least 5 s) counts as the condition holding, unless `on_stale: ignore`.

    - watch:
        - {when: "${{ status.gantry.z > 90 mm }}", then: {fail: too high}}
        - {every: 30 s, id: load, do: balance.weigh, when: "${{ steps.load.mass > 50 g }}", then: [{do: gantry.move_to, with: {z: 0 mm}}, {fail: too heavy}]}
      steps: [{do: libs.measure, timeout: 60 s}]
"""

# ruff: noqa: E501 - a protocol has a line for each step
from .table import table

SHOWS = "{do: b.show, with: {name: show, level: %s}}"


def beside(watch, *, shows="5 mm", steps="{do: a.act, with: {name: long, seconds: 3}}", more=""):
    """A watched group on `a`, while `b` shows something after a moment."""
    return f"""
steps:
  - {{do: b.show, with: {{level: 0 mm}}}}
  - {{while: "${{{{ status.b.level != 0 mm }}}}", steps: [{{wait: 20 ms}}]}}
  - parallel:
      - steps:
          - id: g
            watch: [{watch}]
            steps: [{steps}]
            {more}
      - steps: [{{wait: 0.1 s}}, {SHOWS % shows}]
  - {{do: c.act, with: {{name: after}}}}
finally: [{{do: b.show, with: {{level: 0 mm}}}}]
"""


HIGH = 'when: "${{ status.b.level > 3 mm }}"'


def turns(ran, path):
    return [r for r in ran.records if r.kind == "turn" and r.path.endswith(path)]


# fmt: off
test_watching = table(
    ("then_in_its_place", "The condition begins to hold while an action runs -> It is cancelled and has "
     "ended before anything in `then` is sent; the steps after it in the group are not.",
     beside(f"{{{HIGH}, then: [{{do: c.act, with: {{name: instead}}}}]}}",
            steps="{do: a.act, with: {name: long, seconds: 3}}, {do: a.act, with: {name: never}}"),
     {"status": 0, "words": [".", "long", "show.", "instead", "instead.", "after", "after.", "."]}),
    ("then_fails", "`then: {fail: ...}` -> The group fails with these words; `error` says what was seen.",
     beside(f"{{{HIGH}, then: {{fail: \"flood: ${{{{ error.message }}}}\"}}}}"),
     {"status": 1, "reason": "flood: status.b.level > 3 mm (b.level is 5 mm)"}),
    ("the_ladder_around_it", "As before, the group has `on_error: continue`, or a `fallback` -> They decide "
     "as for any failure.",
     beside(f"{{{HIGH}, then: {{fail: flood}}}}", more="on_error: continue"),
     {"status": 0}),
    ("holds_from_the_beginning", "The condition holds when the group begins -> None of its steps is sent.", """
steps:
  - {do: b.show, with: {level: 5 mm}}
  - {while: "${{ status.b.level != 5 mm }}", steps: [{wait: 20 ms}]}
  - watch: [{when: "${{ status.b.level > 3 mm }}", then: {log: high}}, {when: "${{ status.b.level > 4 mm }}", then: {do: c.act, with: {name: instead}}}]
    steps: [{do: a.act, with: {name: never}}]
finally: [{do: b.show, with: {level: 0 mm}}]
""", {"status": 0, "sent": ["instead"], "logged": ["high"]}),
    ("never_holds", "The condition never holds -> The steps run to their end.",
     beside(f"{{{HIGH}, then: {{fail: flood}}}}", shows="2 mm", steps="{do: a.act, with: {name: short, seconds: 0.5}}"),
     {"status": 0}),
    ("once_per_rise", "`then` only tells, and the condition holds twice -> It is told twice, and the steps go on.", """
steps:
  - {do: b.show, with: {level: 0 mm}}
  - {while: "${{ status.b.level != 0 mm }}", steps: [{wait: 20 ms}]}
  - parallel:
      - steps:
          - watch: [{when: "${{ status.b.level > 3 mm }}", then: {notify: "high: ${{ status.b.level }}"}}]
            steps: [{while: "${{ status.b.level != 7 mm }}", steps: [{wait: 20 ms}]}, {do: a.act, with: {name: on}}]
      - steps:
          - foreach: {level: "${{ [5 mm, 6 mm, 0 mm, 7 mm] }}"}
            steps:
              - {do: b.show, with: {level: "${{ level }}"}}
              - {while: "${{ status.b.level != level }}", steps: [{wait: 20 ms}]}
finally: [{do: b.show, with: {level: 0 mm}}]
""", {"status": 0, "logged": ["high: 5 mm", "high: 7 mm"], "sent": ["on"]}),
    ("a_dead_sensor", "The device that tells it no longer answers -> After `stale` that counts as the "
     "condition holding, and is told as that, with the words of `fail` behind it.",
     beside(f"{{{HIGH}, stale: 0.5 s, then: {{fail: flood}}}}", shows="-1 mm"),
     {"status": 1, "reason": " s (watched for: flood)"}),
    ("a_dead_sensor_ignored", "As before, with `on_stale: ignore` -> The steps run to their end.",
     beside(f"{{{HIGH}, stale: 0.3 s, on_stale: ignore, then: {{fail: flood}}}}", shows="-1 mm",
            steps="{do: a.act, with: {name: long, seconds: 1}}"),
     {"status": 0}),
    ("reads_a_device", "`do` reads a device `every` so often, also one that the group uses where its action is "
     "`meanwhile` -> Its result has the watch's `id`, in `then`, too.", """
steps:
  - {do: a.show, with: {level: 4 mm}}
  - watch:
      - {every: 0.1 s, id: now, do: a.read, when: "${{ steps.now.level > 3 mm }}", then: {log: "at ${{ steps.now.level }}"}}
      - {every: 0.3 s, id: later, do: a.read, when: "${{ steps.later.level > 3 mm }}", then: [{fail: "at ${{ steps.later.level }}"}]}
    steps: [{do: a.act, with: {name: long, seconds: 3}}]
finally: [{do: a.show, with: {level: 0 mm}}]
""", {"status": 1, "logged": ["at 4 mm"], "reason": "at 4 mm", "done": ["", ""]}),
    ("a_reading_that_fails", "`do` fails for longer than `stale` -> It counts as the condition holding, too.", """
steps:
  - {do: b.show, with: {level: -1 mm}}
  - watch: [{every: 0.1 s, stale: 0.5 s, id: now, do: b.read, when: "${{ steps.now.level > 3 mm }}", then: {fail: "${{ error.message }}"}}]
    steps: [{do: a.act, with: {name: long, seconds: 3}}]
finally: [{do: b.show, with: {level: 0 mm}}]
""", {"status": 1, "reason": "its sensor does not answer"}),
)
# fmt: on


def test_then_pause(run):
    """`then: pause` -> The run is paused and says why; `labrun continue` goes on with the steps."""
    body = beside(f"{{{HIGH}, then: pause}}", steps="{do: a.act, with: {name: one, seconds: 0.5}}, "
                  "{do: a.act, with: {name: two}}")  # fmt: skip

    ran = run(body, go_on="control pause")

    assert ran.status == 0
    assert ran.done.count("two") == 1
    assert any("status.b.level > 3 mm (b.level is 5 mm)" in line for line in ran.said)


def test_a_paused_run_is_watched_too(run):
    """The condition begins to hold while the run is paused -> `then` is done at once; the rest
    waits for `labrun continue`."""
    body = """
steps:
  - {do: a.show, with: {level: 4 mm}}
  - watch: [{every: 0.4 s, id: now, do: a.read, when: "${{ steps.now.level > 3 mm and elapsed() > 0.3 s }}", then: {do: c.act, with: {name: stop}}}]
    steps: [{do: a.act, with: {name: one, seconds: 0.2}}, {do: a.act, with: {name: never}}]
  - {do: b.act, with: {name: after}}
finally: [{do: a.show, with: {level: 0 mm}}]
"""

    ran = run(body, pause="goal sent main/1/0")
    moments = {r.id.partition("/")[2]: r.n for r in ran.records if r.kind == "goal"}
    resumed = next(r.n for r in ran.records if r.kind == "control" and r.verb == "continue")

    assert ran.status == 0
    assert "never" not in ran.sent
    assert moments["main/1/w1.1/0/1"] < resumed < moments["main/2/1"]


def test_killed_after_it_was_right(bench):
    """A watch was right, and the engine is killed in `then` -> The resumed run goes on in `then`, whatever
    the condition is now, and does nothing twice."""
    body = beside(
        f"{{{HIGH}, then: [{{do: c.shoot, with: {{name: stop}}}}, {{do: c.act, with: {{name: slow, seconds: 0.3}}}}]}}",
        steps="{do: a.shoot, with: {name: first}}, {do: a.act, with: {name: long, seconds: 3}}",
    )
    bench.kill(body, "feedback main/2/0/g/w1.1/1")

    ran = bench.resume()

    assert ran.status == 0
    assert (ran.done.count("first"), ran.done.count("stop"), ran.done.count("after")) == (1, 1, 1)
    assert len([t for t in turns(ran, "g/w1") if t.error]) == 1


def test_resumed_after_it_made_the_run_fail(bench):
    """A watch made the run fail, and it is resumed -> The steps go on where they were, and are watched again:
    while the condition holds, nothing of them is sent."""
    watch = f"{{{HIGH}, then: [{{do: c.act, with: {{name: stop}}}}, {{fail: flood}}]}}"
    body = beside(
        watch,
        steps="{do: a.shoot, with: {name: first}}, {do: a.act, with: {name: long, seconds: 0.6}}",
    )
    body = body.replace("finally: [{do: b.show, with: {level: 0 mm}}]", "")

    failed = bench.run(body)
    again = bench.resume()

    assert (failed.status, again.status) == (1, 1)
    assert [again.done.count(name) for name in ("first", "long", "stop")] == [1, 0, 2]


def test_a_fact_stays_told(bench):
    """`then` has told something, the condition still holds, and the engine is killed -> The resumed run
    does not tell it again."""
    body = """
steps:
  - watch: [{when: "${{ status.c.level > 3 mm }}", then: {notify: high}}]
    steps: [{do: c.show, with: {level: 5 mm}}, {do: a.shoot, with: {name: first, seconds: 1}}]
"""
    bench.kill(body, "step main/0/w1.1")

    ran = bench.resume()

    assert ran.status == 0
    assert ran.logged == ["high"]


def test_aborted_in_then(run):
    """The run is aborted in `then` -> What runs there is cancelled; `finally` runs."""
    body = beside(f"{{{HIGH}, then: {{do: c.act, with: {{name: slow, seconds: 3}}}}}}")

    ran = run(body, abort="feedback .* main/2/0/g/w1.1/0")

    assert ran.finished.fate == "aborted"
    assert "slow" not in ran.done
