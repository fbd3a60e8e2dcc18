"""`finally`, the safe state and `on_resume`

`finally` runs at the end of every run, however it ended. After it every device that was used goes
into the safe state of its contract. `on_resume` runs when a run is resumed, before its steps
continue.

    finally:
      - {do: gantry.move_to, with: {z: 50 mm}}
    on_resume:
      - do: gantry.home
"""

from .table import table

TIDY = "finally: [{do: b.act, with: {name: tidy}}]\n"


# fmt: off
test_finally = table(
    ("finally_after_a_success", "The run succeeds -> `finally` runs after the last step.",
     "steps: [{do: a.act, with: {name: x}}]\n" + TIDY, {"status": 0, "sent": ["x", "tidy"]}),
    ("finally_after_a_failure", "A step fails -> `finally` runs; the run has failed.",
     "steps: [{do: a.act, with: {name: x, script: Broken}}]\n" + TIDY,
     {"status": 1, "fate": "failed", "sent": ["x", "tidy"]}),
    ("finally_after_an_abort",
     "Abort -> What runs is cancelled and has ended; then `finally` runs, and is not cut short by that "
     "abort.", "steps: [{id: x, do: a.act, with: {name: x, script: hang}}]\n" + TIDY,
     {"fate": "aborted", "words": ["x", "tidy", "tidy."]}, {"abort": "feedback .* main/x"}),
)
# fmt: on


def test_finally_that_fails(run):
    """Steps of `finally` fail -> Its later steps run all the same; the run has failed, though all
    its steps succeeded, and its reason names each of them."""
    ran = run("""
steps: [{do: a.act, with: {name: x}}]
finally:
  - {do: b.act, with: {name: tidy, script: Broken}}
  - {do: c.act, with: {name: close}}
  - steps: [{do: a.act, with: {name: dry, script: Half}}, {do: a.act, with: {name: never}}]
  - {do: b.act, with: {name: last}}
""")

    assert (ran.status, ran.finished.fate) == (1, "failed")
    assert ran.sent == ["x", "tidy", "close", "dry", "last"]
    assert ran.finished.detail.startswith("finally: ")
    assert "Broken" in ran.finished.detail and "Half" in ran.finished.detail


def test_finally_that_need_not_succeed(run):
    """A step of `finally` fails, `on_error: continue` -> The run has succeeded, and says what failed
    there."""
    ran = run("""
steps: [{do: a.act, with: {name: x}}]
finally:
  - {do: b.act, with: {name: tidy, script: Broken}, on_error: continue}
  - {do: c.act, with: {name: last}}
""")

    assert (ran.status, ran.finished.fate, ran.sent) == (0, "succeeded", ["x", "tidy", "last"])
    assert ran.finished.reason.startswith("finally: ")
    assert "Broken" in ran.finished.reason


def test_finally_of_an_aborted_run(run):
    """Abort, and a step of `finally` fails -> Its later steps run; the run is aborted."""
    ran = run(
        """
steps: [{id: x, do: a.act, with: {name: x, script: hang}}]
finally:
  - {do: b.act, with: {name: tidy, script: Broken}}
  - {do: c.act, with: {name: last}}
""",
        abort="feedback .* main/x",
    )

    assert (ran.finished.fate, ran.sent) == ("aborted", ["x", "tidy", "last"])


def test_finally_knows_the_results(run):
    """`finally` uses results of the steps -> It sees them; null where a step did not run."""
    ran = run("""
steps:
  - {id: one, do: a.act, with: {name: one}}
  - {id: two, do: a.act, with: {name: two, script: Broken}}
finally:
  - {do: b.act, with: {name: "${{ steps.one.name }} ${{ 'two' if steps.two else 'null' }}"}}
""")

    assert ran.sent == ["one", "two", "one null"]


def test_the_safe_state_comes_last(run):
    """After `finally`, also after one that failed -> Every device that was used goes into its safe
    state."""
    ran = run("""
steps: [{do: a.act, with: {name: x}}]
finally: [{do: b.act, with: {name: tidy, script: Broken}}]
""")

    safe = [(r.device, r.confirmed) for r in ran.records if r.kind == "safe"]
    assert safe == [("a", True), ("b", True)]
    assert [r.kind for r in ran.records].index("safe") > max(
        r.n - 1 for r in ran.records if r.kind == "ended"
    )


def test_a_second_abort(run):
    """A second abort, while `finally` runs -> It is ended at once; devices still go into their safe
    state."""
    ran = run(
        "steps: [{id: x, do: a.act, with: {name: x, script: hang}}]\n"
        "finally: [{id: long, do: b.act, with: {name: long, script: hang}}]\n",
        abort="feedback .* main/x",
        abort_now="feedback .* finally:1/long",
    )

    assert ran.finished.fate == "aborted"
    assert {r.device for r in ran.records if r.kind == "safe"} == {"a", "b"}


def test_after_a_kill_the_tidying_comes_first(bench):
    """A run whose engine was killed is resumed -> First `finally` and the safe state, which had not
    been reached; then `on_resume`; then the steps continue; `finally` once more at the end."""
    bench.kill(
        """
steps:
  - {do: a.shoot, with: {name: shot}}
  - {id: x, do: a.shoot, with: {name: x, seconds: 0.2}}
on_resume: [{do: c.act, with: {name: home}}]
"""
        + TIDY,
        "ended main/0/1",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["shot", "tidy", "home", "x", "tidy"]


def test_after_an_ending_only_on_resume(bench):
    """A run that had failed or was aborted is resumed -> `on_resume`, then the steps continue;
    `finally` had run already, and runs again at the end."""
    bench.run(
        "steps: [{do: a.shoot, with: {name: shot}}, {do: a.shoot, with: {name: x, script: 'Broken,ok'}}]\n"
        "on_resume: [{do: c.act, with: {name: home}}]\n" + TIDY
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["shot", "x", "tidy", "home", "x", "tidy"]


def test_on_resume_that_fails(bench):
    """A step of `on_resume` fails -> No other step is sent; `finally` runs; the run has failed."""
    bench.run(
        "steps: [{do: a.shoot, with: {name: x, script: 'Broken,ok'}}]\n"
        "on_resume: [{do: c.act, with: {name: home, script: Broken}}]\n" + TIDY
    )

    ran = bench.resume()

    assert ran.status == 1
    assert ran.sent == ["x", "tidy", "home", "tidy"]
    assert "resume:1" in ran.finished.detail


def test_a_first_run_has_no_on_resume(run):
    """A run that was not interrupted -> `on_resume` does not run."""
    ran = run(
        "steps: [{do: a.act, with: {name: x}}]\non_resume: [{do: c.act, with: {name: never}}]\n"
    )

    assert ran.sent == ["x"]


def test_a_pause_lets_what_runs_end(run):
    """The run is paused -> Running actions finish; nothing is sent until the run is continued."""
    ran = run(
        """
steps:
  - {id: x, do: a.act, with: {name: x, seconds: 0.2}}
  - {do: b.act, with: {name: y}}
""",
        pause="feedback .* main/x",
    )

    kinds = [r.verb if r.kind == "control" else r.kind for r in ran.records]
    assert ran.status == 0
    assert kinds.index("ended") < kinds.index("continue")
    assert kinds.index("continue") < len(kinds) - 1 - kinds[::-1].index("goal")


STOPPED = """
steps:
  - foreach: {i: [0, 1]}
    keep_going: {max_failed: 2}
    steps:
      - {do: a.act, with: {name: "set${{ i }}"}}
      - {id: x, do: WHAT, with: {name: "x${{ i }}", MORE}, on_error: continue}
      - {do: b.act, with: {name: "y${{ i }}"}}
on_resume: [{do: c.act, with: {name: home}}]
"""
MOVE = STOPPED.replace("WHAT", "a.act").replace(
    "MORE", """script: "${{ 'hang,ok' if i else 'ok' }}\""""
)
SHOT = STOPPED.replace("WHAT", "a.shoot").replace("MORE", 'seconds: "${{ 20 if i else 0 }}"')


def test_a_device_that_somebody_stops(run):
    """A device is stopped by somebody else (`labrun stop`, STOP on the page) -> The run is paused,
    sends nothing and says who it was. After `labrun continue`: `on_resume`, then what the stop cut is
    done; no iteration has failed."""
    ran = run(MOVE, stop="feedback .* main/0/1/x", go_on="control pause")

    assert (ran.status, ran.finished.holes) == (0, 0)
    assert ran.sent == ["set0", "x0", "y0", "set1", "x1", "home", "set1", "x1", "y1"]
    (pause, _) = [r for r in ran.records if r.kind == "control"]
    assert "a was stopped by Ada (the STOP button)" in pause.by


def test_a_shot_in_flight_when_its_device_is_stopped(run):
    """As before, while a `once` action runs that ends in spite of the stop -> It is done, and not
    sent again; its record in the journal says that the device was stopped meanwhile."""
    ran = run(SHOT, stop="feedback .* main/0/1/x", go_on="control pause")

    assert (ran.status, ran.finished.holes) == (0, 0)
    assert ran.sent == ["set0", "x0", "y0", "set1", "x1", "home", "set1", "y1"]
    assert [r.error.name for r in ran.records if r.kind == "ended" and r.error] == ["Stopped"]


def test_a_stopped_run_that_is_aborted(bench):
    """A device is stopped, and the run is aborted in the pause -> What the stop cut is unfinished:
    `labrun resume` does it."""
    steers = {"stop": "feedback .* main/0/1/x", "abort": "control pause"}
    first = bench.run(MOVE, **steers)

    ran = bench.resume()

    assert (first.status, ran.status, ran.finished.holes) == (1, 0, 0)
    assert ran.sent == ["set0", "x0", "y0", "set1", "x1", "home", "set1", "x1", "y1"]


def test_a_stop_in_on_resume(bench):
    """A device is stopped while `on_resume` runs -> The run is paused. After `labrun continue`: `on_resume`
    from its beginning, then the steps."""
    body = "steps: [{do: b.act, with: {name: x, script: 'Broken,ok'}}]\n"
    bench.run(body + "on_resume: [{do: a.act, with: {name: home, seconds: 0.4}}]\n")

    ran = bench.resume(stop="feedback .* resume:1/", go_on="control pause")

    assert ran.status == 0
    assert ran.sent == ["x", "home", "home", "x"]
    assert "Ada (the STOP button)" in " ".join(r.by for r in ran.records if r.kind == "control")


def test_a_stop_in_finally(bench):
    """A device is stopped while `finally` runs -> Nothing more is sent to it, what other devices do there is
    done, and the run has failed by the stop, whose name it tells. `labrun resume` runs `finally` again."""
    body = """
steps: [{do: b.act, with: {name: x}}]
finally:
  - {do: a.act, with: {name: park, script: "hang,ok"}}
  - {do: a.act, with: {name: off}}
  - {do: b.act, with: {name: vent}}
"""
    stopped = bench.run(body, stop="feedback .* finally:1/")
    reason = stopped.finished.reason

    ran = bench.resume()

    assert (stopped.status, ran.status) == (1, 0)
    assert reason[:-8] == "finally: a.act: a was stopped by Ada (the STOP button) at "
    assert ran.sent == ["x", "park", "vent", "x", "park", "off", "vent"]
