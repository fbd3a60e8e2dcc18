"""`confirm` and `ask`

A person answers in the terminal, on the page, or from another shell (`labrun answer RUN ID
CHOICE`). Nothing after the question is sent before the answer.

    - {id: ready, confirm: Is the argon open?}
    - {id: colour, ask: Which colour has it?, choices: [clear, yellow], timeout: 10 min}
"""

from .table import table

# fmt: off
test_answers = table(
    ("a_yes", "`confirm` is answered `yes` -> The run continues.",
     "steps: [{id: sure, confirm: 'Sure?'}, {do: a.act, with: {name: x}}]\n",
     {"status": 0, "sent": ["x"]}, {"answers": {"sure": "yes"}}),
    ("a_no",
     "`confirm` is answered `no` -> The run ends as aborted, whatever `on_error` says; `finally` runs.", """
steps:
  - {id: sure, confirm: "Sure?", on_error: continue}
  - {do: a.act, with: {name: never}}
finally: [{do: b.act, with: {name: tidy}}]
""", {"status": 1, "fate": "aborted", "sent": ["tidy"]}, {"answers": {"sure": "no"}}),
    ("yes_beforehand",
     "`labrun run --yes` -> Every `confirm` is answered `yes`; every `ask` still waits.",
     "steps: [{confirm: 'Sure?'}, {id: how, ask: 'How?', choices: [yes, no], timeout: 0.2 s}]\n",
     {"status": 1, "reason": "Timeout"}, {"yes": True}),
    ("an_answer_is_a_result", "`ask` is answered -> Its result is `{choice}`, for all steps after it.", """
steps:
  - {id: how, ask: "How?", choices: [well, badly]}
  - {when: "${{ steps.how.choice == 'badly' }}", do: a.act, with: {name: help}}
  - {do: b.act, with: {name: "${{ steps.how.choice }}"}}
""", {"sent": ["well"]}, {"answers": {"how": "well"}}),
)
# fmt: on


def test_the_text_is_computed(run):
    """The text contains an expression -> The person sees its value."""
    ran = run(
        """
steps:
  - {id: it, do: a.act, with: {name: x, x: 2}}
  - {id: how, ask: "It is at ${{ steps.it.x }}. Good?", choices: [good, bad]}
""",
        answers={"how": "good"},
    )

    assert [r.text for r in ran.records if r.kind == "asked"] == ["It is at 2 mm. Good?"]


def test_who_answered_is_in_the_journal(run):
    """An answer -> The journal records what was asked, what was answered, and by whom."""
    ran = run("steps: [{id: sure, confirm: 'Sure?'}]\n", answers={"sure": "yes"})

    assert [(r.choice, r.by) for r in ran.records if r.kind == "answered"] == [("yes", "--answer")]


def test_what_runs_beside_it_goes_on(run):
    """A question in one member of a set -> The other members continue while it waits."""
    ran = run("""
steps:
  - on_error: continue
    parallel:
      - steps: [{id: how, ask: "How?", choices: [well], timeout: 0.3 s}]
      - steps: [{do: a.act, with: {name: one}}, {do: a.act, with: {name: two}}]
""")

    assert ran.done == ["one", "two"]


def test_in_a_loop_it_is_asked_in_every_iteration(run):
    """A question in a loop -> It is asked in every iteration."""
    ran = run(
        "steps: [{repeat: 3, steps: [{id: sure, confirm: 'Sure?'}]}]\n", answers={"sure": "yes"}
    )

    assert [r.path for r in ran.records if r.kind == "answered"] == [
        f"main/0/{i}/sure" for i in range(3)
    ]


def test_an_answer_outlives_the_engine(bench):
    """The engine is killed after the answer -> Resume does not ask again."""
    bench.kill(
        """
steps:
  - {id: how, ask: "How?", choices: [well, badly]}
  - {id: long, do: a.act, with: {name: "${{ steps.how.choice }}", seconds: 0.2}}
""",
        "feedback main/long",
        answers={"how": "well"},
    )

    ran = bench.resume()

    assert ran.status == 0
    assert set(ran.sent) == {"well"}
    assert len([r for r in ran.records if r.kind == "asked"]) == 1


def test_a_question_that_was_open_is_asked_again(bench):
    """The engine is killed while a question is open -> Resume asks it again."""
    bench.kill("steps: [{id: how, ask: 'How?', choices: [well]}]\n", "asked main/how")

    ran = bench.resume(answers={"how": "well"})

    assert ran.status == 0
    assert len([r for r in ran.records if r.kind == "answered"]) == 1


def test_abort_withdraws_the_question(run):
    """Abort while a question is open -> It is withdrawn; nothing after it is sent."""
    ran = run(
        "steps: [{id: how, ask: 'How?', choices: [well]}, {do: a.act, with: {name: never}}]\n",
        abort="question open main/how",
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == []
