"""`functions`: functions of one's own

`functions: {far: ./own.py:far}` names Python functions in files beside the protocol. They are called in a
`set`, each call in a process of its own, for at most the `timeout` of the step (60 s without one). What a
function takes and gives is what its annotations say, with units: `Annotated[float, "mm"]`; a bare number
is in that unit. The run keeps a copy of the file, and what a call gave is in the journal.

    - {id: weight, do: balance.weigh}
    - set: {ratio: "${{ steps.weight.mass / params.dose }}"}
    - {log: enough, when: "${{ ratio > 1 }}"}
"""

OWN = """
import os, time
from typing import Annotated

def longest(x: list[Annotated[float, "mm"]], more: Annotated[float, "mm"] = 0.0) -> Annotated[float, "cm"]:
    print("printed by a function")
    return (max(x) + more) / 10

def note(path: str) -> int:
    with open(path, "a") as file:
        file.write("x")
    return os.path.getsize(path)

def fails(x: float) -> float:
    return 1 / (x - x)

def sleeps(x: float) -> float:
    time.sleep(x)
    return x
"""
BESIDE = {"own.py": OWN}


def test_a_function_computes_with_units(run):
    """`set: {far: f(...)}` -> It gets plain numbers in the units that it asks for; its result has the
    unit that it says."""
    ran = run(
        """
functions: {longest: ./own.py:longest}
steps:
  - {id: one, do: a.act, with: {name: one, x: 2}}
  - set: {far: "${{ longest([steps.one.x, 1 mm], more=1 mm) + longest([1]) }}"}
  - {do: a.act, with: {name: "at ${{ far }}", x: "${{ far }}"}}
""",
        beside=BESIDE,
    )

    assert ran.status == 0
    assert ran.sent == ["one", "at 0.4 cm"]


def test_a_function_is_called_once(bench):
    """The engine is killed after a call -> The resumed run computes with what it gave."""
    notes = bench.folder / "notes"
    bench.kill(
        f"""
functions: {{note: ./own.py:note}}
steps:
  - set: {{n: "${{{{ note('{notes}') }}}}"}}
  - {{do: a.act, with: {{name: "n ${{{{ n }}}}", seconds: 0.2}}}}
outputs: {{n: "${{{{ n }}}}"}}
""",
        "feedback main/1",
        beside=BESIDE,
    )
    (bench.folder / "own.py").write_text("raise SystemExit")  # the run has a copy

    ran = bench.resume()

    assert (ran.status, ran.outputs) == (0, {"n": 1})
    assert notes.read_text() == "x"


def test_a_function_that_raises(run):
    """A function raises -> The step fails with `FunctionFailed`, which says what and in which line."""
    ran = run(
        """
functions: {fails: ./own.py:fails}
steps:
  - do: a.act
    with: {name: before}
  - steps: [{set: {x: "${{ fails(3) }}"}}]
    fallback: [[{do: a.act, with: {name: "instead: ${{ error.name }}"}}]]
  - set: {y: "${{ fails(3) }}"}
outputs: {x: "${{ y }}"}
""",
        beside=BESIDE,
    )

    assert (ran.status, ran.sent) == (1, ["before", "instead: FunctionFailed"])
    assert "fails: ZeroDivisionError: division by zero (./own.py, line 15)" in ran.finished.reason


def test_a_function_that_takes_too_long(run, monkeypatch):
    """A call takes longer than the `timeout` of its `set` -> Its process is killed, the step fails with
    `Timeout`; devices are followed meanwhile."""
    monkeypatch.setattr("labrun.engine.tree.tick.QUIET_S", 0.05)
    ran = run(
        """
functions: {sleeps: ./own.py:sleeps}
steps:
  - parallel:
      - steps: [{set: {x: "${{ sleeps(60) }}"}, timeout: 0.6 s}]
        on_error: continue
      - steps: [{do: b.act, with: {name: one}}, {do: b.act, with: {name: two}}]
""",
        beside=BESIDE,
    )

    assert (ran.status, ran.done) == (0, ["one", "two"])
    assert any("took longer than its timeout" in line for line in ran.said)
    assert "still waiting for the function sleeps" in ran.said


def test_an_abort_ends_a_function(run):
    """The run is aborted during a call -> The call ends at once."""
    ran = run(
        """
functions: {sleeps: ./own.py:sleeps}
steps:
  - {id: long, set: {x: "${{ sleeps(60) }}"}}
""",
        beside=BESIDE,
        abort="step running main/long",
    )

    assert ran.finished.fate == "aborted"
