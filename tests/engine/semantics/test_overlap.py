"""`at_once`, `reserve`, and groups that share devices

Groups in a `parallel`, in the background, and iterations of a loop with `at_once: N` may use the same
devices: they take turns, in the order in which they ask. `reserve` keeps devices for one group: it
waits until all of them are free, takes them at once, and gives them back when its steps and their background
actions have ended. With `at_once` above 1 and in a background group, what is `set` is known there only.
Rows, counts and limits are those of the iterations in their order, whichever has ended first.

    - foreach: {x: [1 mm, 2 mm, 3 mm]}
      at_once: 2
      steps:
        - reserve: [gantry, libs]
          steps: [{do: gantry.move_to, with: {x: "${{ x }}"}}, {id: shoot, do: libs.measure, timeout: 60 s}]
        - {do: balance.weigh}
"""

# ruff: noqa: E501 - a protocol has a line for each step
from itertools import pairwise

from .table import table

# The first item takes long: the others pass it.
PLATE = """
steps:
  - id: plate
    foreach: {i: [0, 1, 2]}
    at_once: 3
    steps:
      - reserve: [a]
        steps: [{do: a.act, with: {name: "move${{ i }}"}}, {do: a.shoot, with: {name: "shot${{ i }}"}}]
      - {if: "${{ i == 0 }}", then: [{do: b.act, with: {name: long, seconds: 0.8}}], else: [{do: c.act, with: {name: "short${{ i }}"}}]}
    collect: {i: "${{ i }}"}
"""


# Listed, the second item would wait long for its turn on a.
PRESS = """
steps:
  - id: press
    foreach: {long: [3, 1, 2]}
    at_once: 3
    order: shortest
    steps:
      - {do: a.act, with: {name: "fill${{ long }}", seconds: "${{ long / 10 }}"}}
      - {do: b.shoot, with: {name: "press${{ long }}"}}
      - {do: c.act, with: {name: "dry${{ long }}", seconds: "${{ 0.4 - long / 10 }}"}}
    collect: {long: "${{ long }}"}
"""


def ended(ran):
    return [(r.key, r.ahead) for r in ran.records if r.kind == "iteration"]


# fmt: off
test_overlaps = table(
    ("groups_of_a_set_take_turns", "Two members of `parallel` that are groups use one device -> Each action waits "
     "until the one before it has ended, in the order of asking.", """
steps:
  - parallel:
      - steps: [{do: a.act, with: {name: x1, seconds: 0.1}}, {do: a.act, with: {name: x2}}]
      - steps: [{do: a.act, with: {name: y1}}, {do: a.act, with: {name: y2}}]
""", {"status": 0, "words": ["x1", "x1.", "y1", "y1.", "x2", "x2.", "y2", "y2."]}),
    ("reserved_for_one_group", "As before, both `reserve` the device -> The second begins when the first group is over.", """
steps:
  - parallel:
      - {reserve: [a, b], steps: [{do: a.act, with: {name: x1, seconds: 0.1}}, {do: b.act, with: {name: x2}}, {do: a.act, with: {name: x3}}]}
      - {reserve: [a], steps: [{do: a.act, with: {name: y1}}, {do: a.act, with: {name: y2}}]}
""", {"status": 0, "done": ["x1", "x2", "x3", "y1", "y2"]}),
    ("a_reservation_that_fails", "A reserved group fails -> Its devices are free; whoever waits for them goes on.", """
steps:
  - parallel:
      - {reserve: [a], on_error: continue, steps: [{do: a.act, with: {name: x, script: Broken, seconds: 0.1}}]}
      - {reserve: [a], steps: [{do: a.act, with: {name: y}}]}
  - {do: a.act, with: {name: after}}
""", {"status": 0, "done": ["y", "after"]}),
    ("it_ends_with_its_background", "A reserved group begins an action in the background -> It keeps its devices until "
     "that has ended, too.", """
steps:
  - foreach: {i: [0, 1]}
    at_once: 2
    steps:
      - reserve: [a, b]
        steps: [{do: b.act, with: {name: "aside${{ i }}", seconds: 0.2}, mode: background}, {do: a.act, with: {name: "x${{ i }}"}}]
""", {"status": 0, "done": ["x0", "aside0", "x1", "aside1"]}),
    ("a_reservation_within", "A reserved group reserves a part of its devices within -> Nobody else comes in between, "
     "though others asked before.", """
steps:
  - parallel:
      - reserve: [a, b]
        steps:
          - {do: a.act, with: {name: x1, seconds: 0.1}}
          - parallel:
              - {reserve: [a], steps: [{do: a.act, with: {name: x2}}, {do: a.act, with: {name: x3}}]}
              - steps: [{do: a.act, with: {name: x4}}]
      - {reserve: [a], steps: [{do: a.act, with: {name: y}}]}
""", {"status": 0, "done": ["x1", "x2", "x3", "x4", "y"]}),
    ("a_watch_of_a_reserved_group", "A watch of a reserved group is right -> Its `then` uses the devices of the group.", """
steps:
  - {do: b.show, with: {level: 5 mm}}
  - parallel:
      - reserve: [a]
        watch: [{every: 0.2 s, id: now, do: b.read, when: "${{ steps.now.level > 3 mm }}", then: {do: a.act, with: {name: stop}}}]
        steps: [{do: a.act, with: {name: long, seconds: 3}}]
      - {reserve: [a], steps: [{do: a.act, with: {name: y}}]}
finally: [{do: b.show, with: {level: 0 mm}}]
""", {"status": 0, "done": ["", "stop", "y", ""]}),
    ("a_group_in_the_background", "`mode: background` on a group -> The steps after it begin at once; outside loops the "
     "list waits for it; its result is known in `outputs`.", """
steps:
  - id: aside
    mode: background
    steps: [{do: b.act, with: {name: b1, seconds: 0.2}}, {set: {n: 3}}, {do: b.act, with: {name: "b${{ n }}"}}]
  - {do: a.act, with: {name: a1}}
outputs: {name: "${{ steps.aside.name }}"}
""", {"status": 0, "done": ["a1", "b1", "b3"], "outputs": {"name": "b3"}}),
    ("in_a_row_counts_in_order", "`at_once`, and iterations fail -> `in_a_row` counts them in the order of the items; "
     "no other is begun once the loop has to end.", """
steps:
  - foreach: {i: [0, 1, 2, 3, 4, 5, 6, 7]}
    at_once: 2
    keep_going: {in_a_row: 2}
    steps: [{do: b.act, with: {name: "n${{ i }}", script: "${{ 'ok' if i in [0, 2] else 'Broken' }}"}}]
    collect: {i: "${{ i }}"}
""", {"status": 1, "reason": "no more than 2 in a row may fail"}),
    ("a_failure_lets_the_others_end", "`at_once` without `keep_going`, and an iteration fails -> Those under way end; no "
     "other is begun; the loop fails.", """
steps:
  - foreach: {i: [0, 1, 2, 3]}
    at_once: 2
    steps: [{do: b.act, with: {name: "n${{ i }}", seconds: 0.1, script: "${{ 'Broken' if i == 0 else 'ok' }}"}}]
""", {"status": 1, "sent": ["n0", "n1"], "done": ["n1"]}),
    ("a_failure_is_known_before_its_turn", "`at_once` without `keep_going`, and an iteration fails before an earlier one has "
     "ended -> The earlier one ends; no other is begun.", """
steps:
  - foreach: {i: [0, 1, 2, 3]}
    at_once: 2
    steps:
      - if: "${{ i == 0 }}"
        then: [{do: a.act, with: {name: n0, seconds: 0.5}}]
        else: [{do: b.act, with: {name: "n${{ i }}", script: "${{ 'Broken' if i == 1 else 'ok' }}"}}]
""", {"status": 1, "sent": ["n0", "n1"], "done": ["n0"]}),
)
# fmt: on


def test_rows_are_in_order(run):
    """`at_once: 3`, and the first iteration takes longest -> Its devices are shared in turns; the rows are in
    the order of the items."""
    ran = run(PLATE)

    assert ran.status == 0
    assert [row["i"] for row in ran.rows()] == ["0", "1", "2"]
    assert ended(ran) == [("1", True), ("2", True), ("0", False)]
    shots = [name for name in ran.sent if name.startswith(("move", "shot"))]
    assert all(a[4:] == b[4:] for a, b in list(pairwise(shots))[::2])


def test_the_shortest_order(run):
    """`order: shortest`, and the contracts say how long the actions take -> The iterations begin, and have their rows, in
    the order that takes the least time; keys are those of the items as listed."""
    ran = run(PRESS)

    assert ran.status == 0
    assert [word for word in ran.sent if word.startswith("fill")] == ["fill1", "fill2", "fill3"]
    assert [(row["key"], row["long"]) for row in ran.rows()] == [("1", "1"), ("2", "2"), ("0", "3")]


def test_the_shortest_order_of_what_is_not_known(run):
    """`order: shortest`, and nothing is known that tells the iterations apart -> They begin as they are listed."""
    ran = run(PRESS.replace("seconds: ", "x: ").replace("0.4 - ", ""))

    assert ran.status == 0
    assert [word for word in ran.sent if word.startswith("fill")] == ["fill3", "fill1", "fill2"]


def test_killed_in_the_shortest_order(bench):
    """The engine is killed while iterations in the shortest order are under way -> They go on in the same order;
    nothing is sent twice."""
    bench.kill(PRESS, "goal main/press/2/1")

    ran = bench.resume()

    assert ran.status == 0
    assert [(row["key"], row["long"]) for row in ran.rows()] == [("1", "1"), ("2", "2"), ("0", "3")]
    assert [ran.done.count(f"press{long}") for long in (1, 2, 3)] == [1, 1, 1]


def test_killed_with_several_unfinished(bench):
    """The engine is killed while the first of several iterations runs, others behind it have ended -> Those are
    not entered again; no shot is sent twice; the rows are in order."""
    bench.kill(PLATE.replace("seconds: 0.8", "script: held"), "iteration main/plate/2")
    bench.laboratory.log.with_name("long.go").touch()

    ran = bench.resume()

    assert ran.status == 0
    assert [row["i"] for row in ran.rows()] == ["0", "1", "2"]
    assert [ran.done.count(f"shot{i}") for i in range(3)] == [1, 1, 1]
    assert [ran.done.count(f"move{i}") for i in range(3)] == [2, 1, 1]
    assert ran.done.count("short2") == 1


def test_killed_in_a_reservation(bench):
    """The engine is killed between two actions of reserved groups of several iterations -> Each is set again
    before its own shot, and nobody comes in between."""
    body = PLATE.replace(
        'do: a.shoot, with: {name: "shot${{ i }}"',
        'do: a.shoot, with: {seconds: 0.2, name: "shot${{ i }}"',
    )
    bench.kill(body, "goal main/plate/1/0/1")

    ran = bench.resume()

    assert ran.status == 0
    assert [ran.done.count(f"shot{i}") for i in range(3)] == [1, 1, 1]
    *_, last = [i for i, word in enumerate(ran.words) if word == "shot1."]
    moves = [word for word in ran.words[:last] if word.startswith("move")]
    assert moves[-1] == "move1."


def test_tried_again_after_a_pause(bench):
    """A reserved group fails with `on_error: pause`, another one has used its devices before it is tried
    again -> What it had set is set again before it goes on."""
    ran = bench.run(
        """
steps:
  - parallel:
      - reserve: [a]
        steps: [{do: a.tune, with: {name: set1, x: 1}}, {do: a.shoot, with: {name: shot1, script: "Broken,ok"}, on_error: pause}]
      - reserve: [a]
        steps: [{do: a.tune, with: {name: set2, x: 1}}, {do: a.shoot, with: {name: shot2}}]
""",
        go_on="control pause",
    )

    assert ran.status == 0
    before = ran.done[: ran.done.index("shot1")]
    assert [name for name in before if name.startswith("set")][-1] == "set1"
