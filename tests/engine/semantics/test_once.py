"""`once`: what must not happen twice

A contract says for each action whether it may be done twice. A `once` action, such as a laser shot,
is sent again only if it is certain that it did not happen. Each error of a contract says whether
it did: `happened: no | yes | unknown`.

    - do: libs.measure
      retry: 3
      on_unknown: probe
"""

import pytest

from .table import table

# fmt: off
test_what_is_sent_again = table(
    ("it_did_not_happen", "The error says that it did not happen -> `retry` sends it again.",
     'steps: [{do: a.shoot, with: {name: x, script: "Broken,ok"}, retry: 3}]\n',
     {"status": 0, "sent": ["x", "x"]}),
    ("it_did_happen",
     "The error says that it did happen -> `retry` does not send it again; the step fails.",
     'steps: [{do: a.shoot, with: {name: x, script: "Half,ok"}, retry: 3}]\n',
     {"status": 1, "sent": ["x"]}),
    ("it_did_happen_and_is_wanted_again",
     "The error says that it did happen, and `retry.on` names it -> It is sent again: that is what was "
     "requested.", """
steps: [{do: a.shoot, with: {name: x, script: "Half,ok"}, retry: {attempts: 3, on: [Half]}}]
""", {"status": 0, "sent": ["x", "x"]}),
    ("a_fallback_may_follow_on_it_did_happen",
     "The error says that it did happen, and there is a `fallback` -> The fallback is tried.", """
steps: [{do: a.shoot, with: {name: x, script: Half}, fallback: [{do: b.act, with: {name: y}}]}]
""", {"status": 0, "sent": ["x", "y"]}),
    ("unknown_and_the_probe_saw_it",
     "It is unknown whether it happened, and the contract's probe saw it -> It has succeeded, and is not "
     "sent again.", """
steps:
  - {id: shot, do: a.shoot, with: {name: x, script: "happened!"}, retry: 3}
  - {do: a.act, with: {name: after}}
outputs: {n: "${{ steps.shot.n }}"}
""", {"status": 0, "sent": ["x", "after"], "outputs": {"n": 1}}),
    ("unknown_and_the_probe_did_not_see_it",
     "It is unknown, and the probe says that it did not happen -> The attempts continue: `retry` sends "
     "it again.", """
steps:
  - {do: a.shoot, with: {name: before}}
  - {do: a.shoot, with: {name: x, script: "Foggy,ok"}, retry: 2}
""", {"status": 0, "sent": ["before", "x", "x"]}),
)
# fmt: on


UNKNOWN = """
steps:
  - id: all
    foreach: {i: [1, 2]}
    steps:
      - id: shot
        do: a.shoot
        with: {name: "x${{ i }}", script: "${{ 'Foggy,ok' if i == 1 else 'ok' }}"}
        retry: 3
        on_unknown: {policy}
      - {do: b.act, with: {name: "y${{ i }}"}}
"""


def test_unknown_and_repeat(run):
    """It is unknown, `on_unknown: repeat` -> It is sent again: the protocol declares it harmless if
    it happens twice."""
    ran = run(UNKNOWN.replace("{policy}", "repeat"))

    assert (ran.status, ran.sent) == (0, ["x1", "x1", "y1", "x2", "y2"])


def test_unknown_and_skip(run):
    """It is unknown, `on_unknown: skip` -> The iteration ends there as a hole; nothing is sent
    again."""
    ran = run(UNKNOWN.replace("{policy}", "skip"))

    assert (ran.status, ran.sent) == (0, ["x1", "x2", "y2"])
    assert ran.finished.holes == 1


@pytest.mark.parametrize(
    ("answer", "sent", "fate"),
    [
        ("repeat", ["x1", "x1", "y1", "x2", "y2"], "succeeded"),
        ("skip", ["x1", "x2", "y2"], "succeeded"),
        ("stop", ["x1"], "aborted"),
    ],
)
def test_unknown_and_ask(run, answer, sent, fate):
    """It is unknown, `on_unknown: ask` -> A person looks and answers `repeat`, `skip` (a hole) or
    `stop`."""
    ran = run(UNKNOWN.replace("{policy}", "ask"), answers={"shot": answer})

    assert ran.finished.fate == fate
    assert ran.sent == sent


def test_unknown_and_nothing_to_probe(run):
    """It is unknown, and the contract has no probe, or the probe proves nothing -> A person is
    asked."""
    ran = run(
        'steps: [{id: shot, do: a.pulse, with: {name: x, script: "Foggy,ok"}, retry: 2}]\n',
        answers={"shot": "repeat"},
    )

    assert (ran.status, ran.sent) == (0, ["x", "x"])
    assert [r.id for r in ran.records if r.kind == "asked"] == ["shot"]


def test_idempotent_actions_are_simply_sent_again(run):
    """An action that may be done twice ends with an unknown error -> `retry` sends it again; nobody
    is asked."""
    ran = run('steps: [{do: a.act, with: {name: x, script: "Foggy,ok"}, retry: 2}]\n')

    assert (ran.status, ran.sent) == (0, ["x", "x"])


def test_a_shot_before_a_kill_is_not_fired_again(bench):
    """The engine is killed after the shot and before it heard of it -> Resume asks the device, and
    does not send it again."""
    bench.kill(
        """
steps:
  - {id: shot, do: a.shoot, with: {name: shot, seconds: 0.05}}
  - {do: b.act, with: {name: "after ${{ steps.shot.n }}"}}
""",
        "feedback main/shot",
    )

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["shot", "after 1"])


def test_a_failed_shot_before_a_kill_counts(bench):
    """The engine is killed after a shot that failed and did happen -> Resume does not send it
    again; the step fails."""
    bench.kill(
        "steps: [{id: shot, do: a.shoot, with: {name: shot, script: 'Half,ok'}, retry: 3}]\n",
        "ended main/shot/1",
    )

    ran = bench.resume()

    assert (ran.status, ran.sent) == (1, ["shot"])
