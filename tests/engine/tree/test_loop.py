"""What a loop tells while it runs, and what the journal keeps of it."""

LOOP = """
steps:
  - id: scan
    foreach: {i: [1, 2, 3]}
    keep_going: {max_failed: MAX}
    steps: [{do: a.act, with: {name: "x${{ i }}", script: "${{ 'Broken' if i == 2 else 'ok' }}"}}]
"""


def counts_of(ran):
    loop = [r for r in ran.records if r.kind == "loop"][-1]
    return loop.fate, loop.total, loop.succeeded, loop.failed, loop.skipped


def test_the_journal_keeps_how_a_loop_ended_and_its_counts(own_device):
    ran = own_device().run(LOOP.replace("MAX", "1"))

    assert (ran.status, ran.finished.holes) == (0, 1)
    assert counts_of(ran) == ("succeeded", 3, 2, 1, 0)


def test_a_loop_that_ends_its_run_failed(own_device):
    ran = own_device().run(LOOP.replace("MAX", "0"))

    assert (ran.status, ran.finished.holes) == (1, 0)
    assert counts_of(ran) == ("failed", 1, 1, 0, 0)


def test_every_iteration_is_told_as_it_begins_and_ends(own_device):
    told = []

    def watch(event):
        if event.event == "iteration":
            told.append(
                (event.state, event.data.get("key"), event.data["done"], event.data["failed"])
            )

    own_device().run(LOOP.replace("MAX", "1"), watch=watch)

    assert told == [
        ("begun", None, 0, 0),
        ("running", "0", 0, 0),
        ("succeeded", "0", 1, 0),
        ("running", "1", 1, 0),
        ("failed", "1", 2, 1),
        ("running", "2", 2, 1),
        ("succeeded", "2", 3, 1),
        ("ended", None, 3, 1),
    ]


def test_the_counts_of_a_loop_go_on_over_a_resume(own_device):
    device = own_device()
    device.run(LOOP.replace("MAX", "0").replace("'Broken'", "'Broken,ok'"))

    ran = device.resume()

    assert ran.status == 0
    assert counts_of(ran) == ("succeeded", 3, 3, 0, 0)


def test_a_failure_in_the_background_lets_the_other_iterations_end_first(own_device):
    ran = own_device().run("""
steps:
  - id: scan
    foreach: {i: [1, 2]}
    steps:
      - do: a.act
        with: {name: "x${{ i }}", script: "${{ 'Broken' if i == 1 else 'ok' }}"}
        mode: background
""")

    assert ran.status == 1
    assert [(r.key, r.fate) for r in ran.records if r.kind == "iteration"] == [("1", "succeeded")]
    assert counts_of(ran) == ("failed", 1, 1, 0, 0)


POINTS = """
steps:
  - id: scan
    foreach: {point: "${{ grid(x=span(0 mm, 4 mm, 2 mm), y=span(0 mm, 1 mm, 1 mm)) }}"}
    keep_going: {max_failed: 1}
    steps:
      - set: {ok: "${{ point.x != 4 mm }}"}
      - id: shoot
        do: a.act
        with: {name: "x${{ point.ix }}${{ point.iy }}", script: "${{ 'ok' if ok else 'Broken' }}"}
        retry: 3
"""


def test_a_failure_is_told_in_words_and_its_details_beside_them(own_device):
    told = []
    ran = own_device().run(POINTS, watch=lambda event: told.append((event.event, event.text)))

    assert ran.finished.reason == (
        "point 6 of 6 (x = 4 mm, y = 1 mm): a.act: scripted Broken, 3 tries; no more than 1 may fail"
    )
    assert ran.finished.detail == "main/scan/5/shoot: a.act: Broken: scripted Broken"
    hole = "point 3 of 6 (x = 4 mm, y = 0 mm): a.act: scripted Broken, 3 tries (left out: a hole)"
    tried = "point 3 of 6 (x = 4 mm, y = 0 mm), step shoot: a.act: scripted Broken (attempt 2 of 3, again)"
    assert ("log", hole) in told and ("log", tried) in told


def test_a_hole_is_told_with_the_iterations_around_it_and_long_texts_in_short(own_device):
    told = []
    liquids = ["acid", "water of the tap in the second laboratory, filtered twice"]
    ran = own_device().run(
        f"""
steps:
  - id: liquids
    foreach: {{liquid: {liquids}}}
    steps:
      - id: scan
        foreach: {{i: [1, 2]}}
        keep_going: true
        steps:
          - do: a.act
            with: {{name: x, script: "${{{{ 'Broken' if i == 1 or liquid != 'acid' else 'ok' }}}}"}}
""",
        watch=lambda event: told.append(event.text),
    )

    where = "liquid 2 of 2 (water of the tap in the second labora...)"
    assert (
        "liquid 1 of 2 (acid), point 1 of 2 (i = 1): a.act: scripted Broken (left out: a hole)"
        in told
    )
    assert f"{where}, point 2 of 2 (i = 2): a.act: scripted Broken (left out: a hole)" in told
    assert ran.finished.reason == f"{where}: none of its 2 iterations succeeded"


def test_a_long_expression_is_in_the_details_of_a_failure_alone(own_device):
    ran = own_device().run("""
steps:
  - {id: s, do: a.act, with: {name: x}}
  - id: scan
    foreach: {x: "${{ [x / 7 for x in [x for x in range(100) if x > 3] if x + 12.5 > 1 / (0 * steps.s.n)] }}"}
    steps: [{do: a.act, with: {name: y}}]
""")

    assert ran.finished.reason == "step scan: 1 is divided by zero"
    assert ran.finished.detail.startswith(
        "main/scan: Expression: 1 is divided by zero (in [x / 7 for"
    )
