"""`now()`, `elapsed()`, `steps.ID.started`, `steps.ID.took`, `wait: {until}`

What a clock says is kept in the journal where it was first asked, so that a resumed run computes with the
same values: a name, an argument, a branch, the turn of a loop. `now()` is a moment, which text shows with its
offset from UTC; `elapsed()` is the time since its steps began, pauses and interruptions included. Every
step with an id has `started` and `took`; a result's own field of that name wins.

    - set: {begun: "${{ now() }}"}
    - {id: weight, do: balance.weigh}
    - wait: {until: "${{ begun + 10 min }}"}
    - while: ${{ elapsed() < 8 h }}
      steps: [{do: balance.weigh}, {wait: {until: "${{ now() + 5 min }}"}}]
    - {log: "weighed at ${{ steps.weight.started }}, in ${{ steps.weight.took }}"}
"""

import time
from datetime import datetime

from .table import table


def goals(ran):
    return [record.params for record in ran.records if record.kind == "goal"]


def computed(ran, path):
    return [
        record.value for record in ran.records if record.kind == "computed" and record.path == path
    ]


# fmt: off
test_clocks = table(
    ("moments_are_compared_and_subtracted",
     "Two moments -> Their difference is a time, and a time is added to a moment.", """
steps:
  - set: {t: "${{ now() }}"}
  - {require: "${{ now() >= t and t + 1 min > t and (t + 90 s) - t == 1.5 min and now() - t < 60 s }}"}
  - {require: "${{ elapsed() >= 0 s and elapsed() < 1 h }}"}
""", {"status": 0}),
    ("a_moment_is_shown_with_its_offset",
     "A moment in a text, a row, an output, a device's text -> It is written as `2026-11-24T07:00:00+00:00`; "
     "`format(t, '%H:%M')` writes what is asked for.", """
steps:
  - set: {t: "${{ now() }}"}
  - {do: a.act, with: {name: "${{ t }}"}}
  - {require: "${{ len(format(t, '%H:%M')) == 5 }}"}
outputs: {same: "${{ len(format(t)) > 20 }}"}
""", {"status": 0, "outputs": {"same": True}}),
    ("every_step_has_its_times",
     "`steps.ID.took`, of an action, a wait, a loop, a group -> How long it took, with its retries; null "
     "if it did not run.", """
steps:
  - {id: act, do: a.act, with: {name: x, script: "Broken,ok"}, retry: 2}
  - {id: pause, wait: 0.2 s}
  - {id: gone, do: a.act, with: {name: never}, when: "${{ 1 > 2 }}"}
  - {id: all, repeat: 2, steps: [{wait: 0.1 s}]}
  - {require: "${{ steps.pause.took >= 0.2 s and steps.all.took >= 0.2 s and steps.act.took >= 0 s }}"}
  - {require: "${{ steps.pause.started >= steps.act.started + steps.act.took }}"}
outputs: {gone: "${{ steps.gone.took }}", n: "${{ steps.act.n }}"}
""", {"status": 0, "outputs": {"gone": None, "n": 2}}),
)
# fmt: on


def test_a_name_keeps_its_moment_across_a_kill(bench):
    """`set: {t: now()}`, and the engine is killed after it -> The resumed run has the same `t`."""
    bench.kill(
        """
steps:
  - set: {t: "${{ now() }}"}
  - {do: a.act, with: {name: "${{ format(t, '%H:%M:%S.%f') }}"}}
  - {do: a.act, with: {name: long, seconds: 0.2}}
  - {do: b.act, with: {name: "${{ format(t, '%H:%M:%S.%f') }}"}}
""",
        "feedback main/2",
    )

    ran = bench.resume()
    first, *_, last = [goal["name"] for goal in goals(ran)]

    assert ran.status == 0
    assert first == last


def test_an_action_is_asked_for_with_the_moment_that_it_was_sent_with(bench):
    """An argument of a `once` action comes from a clock, and the engine is killed meanwhile -> It is
    adopted, not done again with another argument."""
    bench.kill(
        "steps: [{do: a.shoot, with: {name: \"${{ format(now(), '%H:%M:%S.%f') }}\", seconds: 0.2}}]\n",
        "feedback main/0",
    )

    ran = bench.resume()

    assert (ran.status, len(ran.done)) == (0, 1)


def test_a_retry_asks_the_clock_again(run):
    """An argument of an action that is retried comes from a clock -> Each attempt has its own moment."""
    ran = run("""
steps:
  - do: a.act
    with: {name: "${{ format(now(), '%H:%M:%S.%f') }}", script: "Broken,ok"}
    retry: {attempts: 2, wait: 0.05 s}
""")
    first, second = goals(ran)

    assert first["name"] < second["name"]


def test_a_loop_s_turn_stays_begun(bench):
    """`while: elapsed() < T`, killed in a turn, resumed after T -> The turn is finished, and is the last."""
    bench.kill(
        """
steps:
  - set: {end: "${{ now() + 0.6 s }}"}
  - while: ${{ now() < end }}
    steps: [{do: a.act, with: {name: one, seconds: 0.2}}, {do: b.act, with: {name: two, seconds: 0.5}}]
""",
        "goal main/1/0/1",
    )
    time.sleep(0.6)

    ran = bench.resume()

    assert ran.status == 0
    assert ran.done.count("two") == 1
    assert [r.key for r in ran.records if r.kind == "iteration"] == ["0"]


def test_a_branch_by_the_clock_is_taken_once(bench):
    """`if` and `when` by a clock, killed after them -> The resumed run goes the same way."""
    bench.kill(
        """
steps:
  - set: {soon: "${{ now() + 0.3 s }}"}
  - {id: first, do: a.act, with: {name: early}, when: "${{ now() < soon }}"}
  - {do: a.act, with: {name: long, seconds: 0.2}}
outputs: {n: "${{ steps.first.n }}"}
""",
        "feedback main/2",
    )
    time.sleep(0.4)

    ran = bench.resume()

    assert ran.status == 0
    assert ran.outputs["n"] is not None


def test_a_requirement_that_failed_asks_again(bench):
    """`require` by a clock has failed, and the run is resumed -> It is computed with the time of then; names
    keep theirs."""
    first = bench.run("""
steps:
  - set: {t: "${{ now() }}"}
  - {require: "${{ now() > t + 0.5 s }}"}
""")
    time.sleep(0.6)
    ran = bench.resume()

    assert (first.status, ran.status) == (1, 0)
    assert len(computed(ran, "main/0/now:1")) == 1


def test_a_step_took_what_it_took(bench):
    """`steps.ID.took`, killed after the step -> It is what it was, whenever the run is resumed."""
    bench.kill(
        """
steps:
  - {id: one, do: a.act, with: {name: one}}
  - {do: a.act, with: {name: long, seconds: 0.2}}
  - {require: "${{ steps.one.took < 5 s }}"}
outputs: {took: "${{ steps.one.took }}"}
""",
        "feedback main/1",
    )

    ran = bench.resume()

    assert computed(ran, "main/one/took") == [ran.outputs["took"]]


def test_wait_until(run):
    """`wait: {until: MOMENT}` -> The next step begins then; one that is over does not wait."""
    ran = run("""
steps:
  - set: {t: "${{ now() }}"}
  - {id: w, wait: {until: "${{ t + 0.4 s }}"}}
  - {id: over, wait: {until: "2020-01-01 07:00"}}
  - {require: "${{ now() >= t + 0.4 s }}"}
  - {require: "${{ steps.over.took < steps.w.took + 5 s }}"}
""")

    assert ran.status == 0


def test_wait_until_the_same_moment_after_a_kill(bench):
    """`wait: {until}` and the engine is killed in it -> The resumed run waits for the same moment."""
    bench.kill(
        """
steps:
  - {wait: {until: "${{ now() + 0.5 s }}"}}
  - {do: a.act, with: {name: x}}
""",
        "computed main/0/until",
    )
    time.sleep(0.5)
    began = time.monotonic()
    ran = bench.resume()
    (until,) = computed(ran, "main/0/until")

    assert ran.status == 0
    assert time.monotonic() - began < 30  # a day later, had "now" been asked again and failed
    assert datetime.fromisoformat(until["$moment"]) < datetime.now().astimezone()


def test_a_pause_does_not_put_off_a_time_of_day(run):
    """The run is paused in `wait: {until}` -> The time of day is what it is: it waits no longer for that."""
    ran = run(
        """
steps:
  - set: {t: "${{ now() }}"}
  - {id: w, wait: {until: "${{ t + 0.3 s }}"}}
  - {require: "${{ steps.w.took < 1.6 s }}"}
""",
        pause="step running main/w",
    )

    assert ran.status == 0
