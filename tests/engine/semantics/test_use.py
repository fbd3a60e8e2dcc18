"""`use`: another protocol as one step

The other file's steps run here, on our devices, with their own parameters. It sees none of our names,
and we see none of its steps: it receives values through `with` and returns its `outputs`.

    - id: scan
      use: ./scan_core.yaml
      with: {width: 2 mm}
"""

from .table import table

OTHER = """
params:
  who: {type: string}
  far: {type: quantity, unit: mm, default: 2 mm}
steps:
  - {id: look, do: a.act, with: {name: "${{ params.who }}", x: "${{ params.far }}"}}
outputs: {name: "${{ steps.look.name }}", x: "${{ steps.look.x }}"}
"""
TIDY = """
params:
  script: {type: string, default: ok}
steps: [{id: it, do: a.act, with: {name: it, script: "${{ params.script }}"}}]
finally: [{do: b.act, with: {name: tidy}}]
outputs: {n: "${{ steps.it.n }}"}
"""


def test_its_steps_run_in_the_place_of_the_use(run):
    """A `use` between two steps -> The other protocol's steps run between them, in their order."""
    ran = run(
        """
steps:
  - {do: b.act, with: {name: before}}
  - {use: ./other.yaml, with: {who: it}}
  - {do: b.act, with: {name: after}}
""",
        beside={"other.yaml": OTHER},
    )

    assert ran.sent == ["before", "it", "after"]


def test_the_result_is_its_outputs(run):
    """It succeeds -> The result of the step is the other protocol's `outputs`, units and all."""
    ran = run(
        """
steps:
  - {id: other, use: ./other.yaml, with: {who: it}}
  - {do: b.act, with: {name: "${{ steps.other.name }}", x: "${{ steps.other.x + 1 mm }}"}}
""",
        beside={"other.yaml": OTHER},
    )

    assert [r.params for r in ran.records if r.kind == "goal"][-1] == {"name": "it", "x": 3.0}


def test_parameters_and_their_defaults(run):
    """`with` gives some of its parameters -> Those have the values computed here; the others have
    their defaults."""
    ran = run(
        """
params: {far: {type: quantity, unit: mm, default: 1 mm}}
steps:
  - {use: ./other.yaml, with: {who: one}}
  - {use: ./other.yaml, with: {who: two, far: "${{ params.far * 4 }}"}}
""",
        beside={"other.yaml": OTHER},
    )

    goals = [r.params for r in ran.records if r.kind == "goal"]
    assert goals == [{"name": "one", "x": 2.0}, {"name": "two", "x": 4.0}]


def test_a_value_that_a_parameter_does_not_take(run):
    """A value that turns out not to fit its parameter -> The step fails, and nothing of the other
    protocol is sent."""
    ran = run(
        """
steps:
  - {id: one, do: b.act, with: {name: one}}
  - {use: ./other.yaml, with: {turns: "${{ steps.one.n + 8 }}"}}
""",
        beside={
            "other.yaml": "params: {turns: {type: integer, maximum: 5}}\n"
            "steps: [{repeat: '${{ params.turns }}', steps: [{do: a.act, with: {name: never}}]}]\n"
        },
    )

    assert ran.status == 1
    assert ran.sent == ["one"]
    assert "turns" in ran.finished.detail


def test_names_are_its_own(run):
    """Both protocols `set` the same name and have steps of the same id -> Each sees its own."""
    ran = run(
        """
steps:
  - set: {n: 1}
  - {id: look, do: b.act, with: {name: mine}}
  - use: ./other.yaml
  - {do: b.act, with: {name: "${{ n }} ${{ steps.look.name }}"}}
""",
        beside={
            "other.yaml": "steps:\n  - set: {n: 2}\n  - {id: look, do: a.act, with: {name: theirs}}\n"
            '  - {do: a.act, with: {name: "${{ n }} ${{ steps.look.name }}"}}\n'
        },
    )

    assert ran.sent == ["mine", "theirs", "2 theirs", "1 mine"]


def test_roles_of_other_names(run):
    """`devices: {its: ours}` -> Its role is played by our device; roles that are not named, by ours
    of the same name."""
    ran = run(
        "steps: [{use: ./other.yaml, devices: {a: c}}]\n",
        beside={"other.yaml": TIDY},
    )

    assert {c["name"]: c["device"] for c in ran.calls} == {"it": "c", "tidy": "b"}


def test_its_defaults_are_its_own(run):
    """Both protocols have `defaults` -> Each uses its own."""
    ran = run(
        """
defaults: {retry: 3}
steps:
  - {do: b.act, with: {name: ours, script: "Broken,Broken,ok"}}
  - {use: ./other.yaml, on_error: continue}
""",
        beside={
            "other.yaml": "defaults: {retry: 2}\nsteps: [{do: a.act, with: {name: its, script: Broken}}]\n"
        },
    )

    assert ran.sent == ["ours", "ours", "ours", "its", "its"]


# fmt: off
test_its_finally = table(
    ("its_finally_runs_when_it_has_succeeded",
     "It succeeds -> Its `finally` runs once, before our next step.", """
steps: [{id: other, use: ./other.yaml}, {do: c.act, with: {name: after}}]
outputs: {n: "${{ steps.other.n }}"}
""", {"sent": ["it", "tidy", "after"], "outputs": {"n": 1}}, {"beside": {"other.yaml": TIDY}}),
    ("its_finally_runs_when_it_has_failed",
     "A step of it fails -> Its `finally` runs once; then the `use` fails, and its fallback starts.", """
steps:
  - use: ./other.yaml
    with: {script: Broken}
    fallback: [{do: c.act, with: {name: other}}]
""", {"status": 0, "sent": ["it", "tidy", "other"]}, {"beside": {"other.yaml": TIDY}}),
    ("a_failing_finally_fails_the_use",
     "Its steps succeed and its `finally` fails -> The `use` fails, with the reason of its `finally`.",
     "steps: [{use: ./other.yaml}, {do: c.act, with: {name: never}}]\n",
     {"status": 1, "sent": ["it", "tidy"], "reason": "Half"},
     {"beside": {"other.yaml": TIDY.replace("{name: tidy}", "{name: tidy, script: Half}")}}),
)
# fmt: on


def test_the_first_failure_is_the_reason(run):
    """Its steps fail, and then its `finally` does -> The reason is the failure of its steps."""
    ran = run(
        "steps: [{use: ./other.yaml, with: {script: Broken}}]\n",
        beside={"other.yaml": TIDY.replace("{name: tidy}", "{name: tidy, script: Half}")},
    )

    assert "Broken" in ran.finished.detail
    assert "Half" not in ran.finished.detail


def test_its_finally_knows_its_results(run):
    """A `finally` that uses results of its protocol's steps -> It sees them; those that did not run
    are null."""
    ran = run(
        "steps: [{use: ./other.yaml, on_error: continue}]\n",
        beside={
            "other.yaml": "steps:\n  - {id: one, do: a.act, with: {name: one}}\n"
            "  - {id: two, do: a.act, with: {name: two, script: Broken}}\n"
            "finally:\n"
            "  - {do: b.act, with: {name: \"${{ steps.one.name }} ${{ 'two' if steps.two else 'null' }}\"}}\n"
        },
    )

    assert ran.sent == ["one", "two", "one null"]


NESTED = {
    "outer.yaml": "steps: [{id: deep, use: ./inner.yaml}]\n"
    "finally: [{do: b.act, with: {name: tidy outer}}]\n",
    "inner.yaml": "steps: [{id: it, do: a.act, with: {name: it, script: hang}}]\n"
    "finally: [{do: b.act, with: {name: tidy inner}}]\n",
}


# fmt: off
test_abort_around_its_finally = table(
    ("abort_runs_every_finally_from_the_inside_out",
     "Abort inside -> The action is cancelled; then the `finally` of every protocol runs once, the "
     "innermost first, the run's own last.",
     "steps: [{id: use, use: ./outer.yaml}]\nfinally: [{do: c.act, with: {name: tidy run}}]\n",
     {"fate": "aborted", "sent": ["it", "tidy inner", "tidy outer", "tidy run"]},
     {"beside": NESTED, "abort": "feedback .* main/use/deep/it"}),
    ("abort_after_it_has_ended_does_not_run_its_finally_again",
     "Abort after the `use` has ended -> Its `finally` is not run a second time.",
     "steps: [{use: ./other.yaml}, {id: long, do: c.act, with: {name: long, script: hang}}]\n",
     {"sent": ["it", "tidy", "long"]}, {"beside": {"other.yaml": TIDY}, "abort": "feedback .* main/long"}),
    ("abort_before_it_begins_does_not_run_its_finally",
     "Abort before the `use` has begun -> Its `finally` does not run.",
     "steps: [{id: long, do: c.act, with: {name: long, script: hang}}, {use: ./other.yaml}]\n",
     {"sent": ["long"]}, {"beside": {"other.yaml": TIDY}, "abort": "feedback .* main/long"}),
)
# fmt: on


def test_abort_in_its_finally(run):
    """Abort while its `finally` runs -> That is cancelled, and the whole `finally` runs again at
    the end of the run."""
    ran = run(
        "steps: [{id: use, use: ./other.yaml}]\n",
        beside={
            "other.yaml": TIDY.replace("{do: b.act, with: {name: tidy}}", "{do: c.act, with: {name: first}}, "
                                       '{id: last, do: b.act, with: {name: tidy, script: "hang,ok"}}')
        },
        abort="feedback .* main/use/finally:1/last",
    )  # fmt: skip

    assert ran.sent == ["it", "first", "tidy", "first", "tidy"]
    assert ran.done[-1] == "tidy"


# fmt: off
test_a_use_that_is_cancelled = table(
    ("a_timeout_on_a_use",
     "A `use` takes longer than its `timeout` -> It is cancelled and fails with `Timeout`; its `finally` "
     "runs before anything else.", """
steps:
  - {use: ./other.yaml, with: {script: hang}, timeout: 0.3 s, on_error: continue}
  - {do: c.act, with: {name: after}}
""", {"status": 0, "sent": ["it", "tidy", "after"]}, {"beside": {"other.yaml": TIDY}}),
    ("a_use_that_loses_a_race",
     "A `use` in a member of `any` loses -> It is cancelled; its `finally` runs before the next step.", """
steps:
  - any:
      - steps: [{use: ./other.yaml, with: {script: hang}}]
      - steps: [{wait: 0.2 s}]
  - {do: c.act, with: {name: after}}
""", {"sent": ["it", "tidy", "after"]}, {"beside": {"other.yaml": TIDY}}),
    ("a_use_that_is_cancelled_in_a_set",
     "A `use` in a set is cancelled because another member has failed -> Its `finally` runs before the "
     "set ends.", """
steps:
  - on_failure: cancel
    on_error: continue
    parallel:
      - steps: [{use: ./other.yaml, with: {script: hang}}]
      - steps: [{wait: 0.2 s}, {fail: enough}]
  - {do: c.act, with: {name: after}}
""", {"sent": ["it", "tidy", "after"]}, {"beside": {"other.yaml": TIDY}}),
)
# fmt: on


def test_abort_while_a_stopped_use_is_tidied_up(run):
    """Abort while its `finally` runs after a timeout -> That is cancelled, and runs again at the
    end of the run."""
    ran = run(
        "steps: [{id: use, use: ./other.yaml, with: {script: hang}, timeout: 0.2 s}]\n",
        beside={
            "other.yaml": TIDY.replace("{do: b.act, with: {name: tidy}}",
                                       '{id: last, do: b.act, with: {name: tidy, script: "hang,ok"}}')
        },
        abort="feedback .* main/use/finally:./last",
    )  # fmt: skip

    assert ran.finished.fate == "aborted"
    assert ran.words == ["it", "tidy", "tidy", "tidy."]


def test_skip_within_a_use_in_a_loop(run):
    """A step of it is answered with `skip`, and the `use` is in a loop -> That iteration ends there
    as a hole, after the `finally` of the other protocol; the next one begins."""
    ran = run(
        """
steps:
  - id: all
    foreach: {n: [1, 2]}
    steps:
      - {use: ./other.yaml, with: {script: "${{ 'Broken' if n == 1 else 'ok' }}"}}
      - {do: c.act, with: {name: "after${{ n }}"}}
    collect: {n: "${{ n }}"}
""",
        beside={
            "other.yaml": TIDY.replace(
                "${{ params.script }}\"}}", '${{ params.script }}"}, '
                'fallback: [{id: how, ask: "?", choices: [skip, stop]}]}'
            )
        },
        answers={"how": "skip"},
    )  # fmt: skip

    assert (ran.status, ran.finished.holes) == (0, 1)
    assert ran.sent == ["it", "tidy", "it", "tidy", "after2"]


def test_a_step_that_is_called_finally(run):
    """A step of it has the id `finally` -> It is a step like any other; its `finally` runs as
    well."""
    ran = run(
        "steps: [{use: ./other.yaml}]\n",
        beside={
            "other.yaml": "steps: [{id: finally, steps: [{do: a.act, with: {name: it}}]}]\n"
            "finally: [{do: a.act, with: {name: tidy}}]\n"
        },
    )

    assert ran.sent == ["it", "tidy"]


def test_retry_of_a_use_begins_it_anew(run):
    """A `use` with a `retry` fails -> Its `finally` runs; then the whole protocol starts again,
    with new goal ids."""
    ran = run(
        'steps: [{id: u, use: ./other.yaml, with: {script: "Broken,ok"}, retry: 2}]\n'
        'outputs: {n: "${{ steps.u.n }}"}\n',
        beside={"other.yaml": TIDY},
    )

    goals = [c["goal"] for c in ran.calls if c["word"] != "done"]
    assert ran.sent == ["it", "tidy", "it", "tidy"]
    assert len(set(goals)) == 4
    assert ran.outputs == {"n": 2}


def test_a_use_in_a_loop(run):
    """A `use` in a loop -> It runs once per iteration, with the parameters of that iteration."""
    ran = run(
        """
steps:
  - foreach: {who: [one, two]}
    steps: [{id: u, use: ./other.yaml, with: {who: "${{ who }}"}}]
    collect: {name: "${{ steps.u.name }}"}
""",
        beside={"other.yaml": OTHER},
    )

    assert ran.sent == ["one", "two"]
    assert [row["name"] for row in ran.rows()] == ["one", "two"]


def test_its_background_actions_end_with_it(run):
    """It starts a background action -> The `use` ends when that has ended, too."""
    ran = run(
        "steps: [{use: ./other.yaml}, {do: c.act, with: {name: after}}]\n",
        beside={
            "other.yaml": "steps:\n"
            "  - {do: a.act, with: {name: aside, seconds: 0.3}, mode: background}\n"
            "  - {do: b.act, with: {name: quick}}\n"
        },
    )

    assert ran.words.index("aside.") < ran.words.index("after")


def test_the_answer_to_its_question_is_found_by_its_id(run):
    """It asks a person -> The question has the id that it has in the other protocol."""
    ran = run(
        "steps: [{use: ./other.yaml}]\n",
        beside={
            "other.yaml": "steps: [{id: sure, confirm: 'Sure?'}, {do: a.act, with: {name: it}}]\n"
        },
        answers={"sure": "yes"},
    )

    assert ran.sent == ["it"]


def test_a_no_to_its_confirm_ends_the_whole_run(run):
    """A person answers `no` to its `confirm` -> The whole run ends as aborted; every `finally`
    runs."""
    ran = run(
        "steps: [{use: ./other.yaml, on_error: continue}, {do: c.act, with: {name: never}}]\n",
        beside={
            "other.yaml": "steps: [{id: sure, confirm: 'Sure?'}]\n"
            "finally: [{do: b.act, with: {name: tidy}}]\n"
        },
        answers={"sure": "no"},
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == ["tidy"]


KILLED = {
    "other.yaml": """
params: {who: {type: string}}
steps:
  - {do: a.shoot, with: {name: "${{ params.who }} one"}}
  - foreach: {row: "${{ csv('points.csv', x='mm') }}"}
    steps: [{do: b.shoot, with: {name: "${{ params.who }} ${{ row.x }}"}}]
    collect: {x: "${{ row.x }}"}
finally: [{do: c.act, with: {name: tidy}}]
""",
    "points.csv": "x\n1\n2\n",
}


def test_a_use_goes_on_after_a_kill(bench):
    """The engine is killed inside -> Resume continues inside, at the first unfinished action; its
    `finally` runs once, when it ends."""
    bench.kill(
        "steps: [{id: u, use: ./other.yaml, with: {who: me}}]\n",
        "iteration main/u/1/0",
        beside=KILLED,
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["me one", "me 1 mm", "me 2 mm", "tidy"]
    assert [row["key"] for row in ran.rows()] == ["0", "1"]


def test_resume_needs_nothing_but_the_run_s_folder(bench):
    """As before, and the files beside the protocol were edited or deleted meanwhile -> Resume uses
    the copies of protocols and tables that the run has kept."""
    bench.kill(
        "steps: [{id: u, use: ./other.yaml, with: {who: me}}]\n",
        "iteration main/u/1/0",
        beside=KILLED,
    )
    (bench.folder / "other.yaml").unlink()
    (bench.folder / "points.csv").write_text("x\n7\n8\n9\n")
    (bench.folder / "test.yaml").unlink()

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["me one", "me 1 mm", "me 2 mm", "tidy"]


def test_protocols_within_protocols(bench):
    """It uses a third protocol, and the engine is killed in that; all files are deleted -> Resume
    continues there, and every `finally` runs once, the innermost first."""
    beside = {
        "mid.yaml": "steps: [{id: v, use: ./deep.yaml}]\nfinally: [{do: c.act, with: {name: tidy mid}}]\n",
        "deep.yaml": "steps:\n  - foreach: {r: \"${{ csv('p.csv') }}\"}\n"
        "    steps: [{do: a.shoot, with: {name: 's${{ r.n }}'}}]\n"
        "finally: [{do: c.act, with: {name: tidy deep}}]\n",
        "p.csv": "n\n1\n2\n",
    }
    bench.kill("steps: [{id: u, use: ./mid.yaml}]\n", "iteration main/u/v/0/0", beside=beside)
    for name in beside:
        (bench.folder / name).unlink()

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["s1", "s2", "tidy deep", "tidy mid"])


def test_rows_of_a_use_in_a_loop(run):
    """It is in a loop and collects rows -> One table for all of them; the key of a row begins with
    the outer key."""
    ran = run(
        """
steps:
  - foreach: {k: [A, B]}
    key: ${{ k }}
    steps: [{id: u, use: ./other.yaml, with: {who: "${{ k }}"}}]
""",
        beside=KILLED,
    )

    assert [row["key"] for row in ran.rows()] == ["A/0", "A/1", "B/0", "B/1"]


def test_killed_in_its_finally(bench):
    """The engine is killed in its `finally` -> Resume continues in it; its finished `once` actions
    are not sent again."""
    bench.kill(
        "steps: [{id: u, use: ./other.yaml}, {do: c.act, with: {name: after}}]\n",
        "ended main/u/finally:1/0",
        beside={
            "other.yaml": "steps: [{do: a.shoot, with: {name: it}}]\n"
            "finally: [{do: b.shoot, with: {name: first}}, {do: b.shoot, with: {name: second}}]\n"
        },
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["it", "first", "second", "after"]


def test_killed_in_the_second_attempt(bench):
    """The engine is killed in the second attempt of a retried `use` -> Resume continues in the
    second attempt."""
    bench.kill(
        "steps: [{id: u, use: ./other.yaml, retry: 2}]\n",
        "feedback main/u/r2/u/long",
        beside={
            "other.yaml": "steps:\n  - {id: one, do: a.shoot, with: {name: one}}\n"
            "  - {id: check, do: a.shoot, with: {name: check, script: 'Broken,ok'}}\n"
            "  - {id: long, do: b.shoot, with: {name: long, seconds: 0.2}}\n"
            "finally: [{do: c.shoot, with: {name: tidy}}]\n"
        },
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["one", "check", "tidy", "one", "check", "long", "tidy"]


def test_a_use_that_failed_goes_on_when_the_run_is_resumed(bench):
    """A run that ended inside is resumed -> It resumes at the step that had failed; its `finally`
    runs again at its end."""
    body = "steps: [{id: u, use: ./other.yaml}]\n"
    other = (
        "steps: [{do: a.shoot, with: {name: one}}, {do: b.shoot, with: {name: two, script: 'Broken,ok'}}]\n"
        "finally: [{do: c.act, with: {name: tidy}}]\n"
    )
    bench.run(body, beside={"other.yaml": other})

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["one", "two", "tidy", "two", "tidy"]


def test_the_same_protocol_twice(run):
    """The same protocol is used twice -> Each use has its own results, goals and tables."""
    ran = run(
        """
steps:
  - {id: left, use: ./other.yaml, with: {who: left}}
  - {id: right, use: ./other.yaml, with: {who: right}}
""",
        beside=KILLED,
    )

    goals = [c["goal"] for c in ran.calls if c["word"] != "done"]
    assert len(set(goals)) == len(goals) == 8
    tables = sorted(path.name for path in ran.folder.glob("data*.csv"))
    assert len(tables) == 2
    assert [row["x_mm"] for row in ran.rows(tables[0])] == ["1", "2"]
    assert [row["x_mm"] for row in ran.rows(tables[1])] == ["1", "2"]


def test_its_on_resume(bench):
    """It has an `on_resume`, and the engine is killed inside -> That runs after our own `on_resume`, with the
    parameters of this use, before anything set is set again; a use that is over or has not begun has none."""
    bench.kill(
        """
on_resume: [{do: c.act, with: {name: ours}}]
steps:
  - {use: ./other.yaml, with: {who: over}}
  - {do: b.act, with: {name: set}}
  - foreach: {k: [A, B]}
    key: ${{ k }}
    steps: [{id: u, use: ./other.yaml, with: {who: "${{ k }}"}}]
""",
        "ended main/2/B/u/it/1",
        beside={
            "other.yaml": """
params: {who: {type: string}}
on_resume: [{do: c.act, with: {name: "home ${{ params.who }}"}}]
steps:
  - {id: it, do: a.shoot, with: {name: "it ${{ params.who }}"}}
  - {id: then, do: b.shoot, with: {name: "then ${{ params.who }}"}}
"""
        },
    )

    ran = bench.resume()

    assert ran.status == 0
    done = ["it over", "then over", "set", "it A", "then A", "it B"]
    assert ran.sent == [*done, "ours", "home B", "set", "then B"]


def test_on_resume_of_a_second_attempt(bench):
    """As before, in the second attempt of a retried `use`, within another one -> Those of the uses around
    it come first; that of the first attempt is not due."""
    bench.run(
        "steps: [{id: u, use: ./mid.yaml}]\n",
        beside={
            "mid.yaml": "on_resume: [{do: c.act, with: {name: mid}}]\n"
            "steps: [{id: v, use: ./deep.yaml, retry: 2}]\n",
            "deep.yaml": "on_resume: [{do: c.act, with: {name: deep}}]\n"
            "steps: [{do: a.shoot, with: {name: x, script: 'Broken,Broken,ok'}}]\n",
        },
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["x", "x", "mid", "deep", "x"]
    resumed = [r.id for r in ran.records if r.kind == "goal" and "/resume:" in r.id]
    assert [name.partition("/resume:1/")[2] for name in resumed] == [
        "main/u/0/1", "main/u/v/r2/v/0/1"
    ]  # fmt: skip


def test_on_resume_after_a_stop_in_its_finally(bench):
    """The engine is killed in its `finally` -> Its steps are over: its `on_resume` is not due."""
    bench.kill(
        "steps: [{id: u, use: ./other.yaml}]\n",
        "ended main/u/finally:1/0",
        beside={
            "other.yaml": "steps: [{do: a.shoot, with: {name: it}}]\n"
            "on_resume: [{do: c.act, with: {name: never}}]\n"
            "finally: [{do: b.shoot, with: {name: first}}, {do: b.shoot, with: {name: second}}]\n"
        },
    )

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["it", "first", "second"])
