"""A server that dies under a running engine: what may be requested again is requested again."""

import subprocess
import sys

import pytest

from labrun.engine.journal.journal import read_records

DRIVER = """
import os, signal
from labrun.drivers.driver import Driver

class Mortal(Driver):
    contract = "mortal@1"

    async def press(self, goal, *, lives):
        deaths = self.place.world / "deaths"
        with deaths.open("a") as file:
            file.write("x")
        if len(deaths.read_text()) <= lives:
            os.kill(os.getpid(), signal.SIGKILL)
        return {}
"""
CONTRACT = """
type: mortal@1
actions:
  press:
    effect: EFFECT
    duration: 1 s
    params: {type: object, required: [lives], properties: {lives: {type: integer}}}
"""


def run(folder, *, deaths=0, effect="idempotent", retry="", driver=DRIVER, steps=""):
    (folder / "mortal.py").write_text(driver)
    (folder / "mortal.yaml").write_text(CONTRACT.replace("EFFECT", effect))
    (folder / "lab.yaml").write_text(
        "name: mortal\nsimulated: true\ncontracts: [./mortal.yaml]\n"
        "devices: {m: {contract: mortal@1, driver: './mortal.py:Mortal'}}\n"
    )
    (folder / "p.yaml").write_text(
        "labrun: 1\nname: p\ndevices: {m: mortal@1}\n"
        f"steps: [{steps or f'{{do: m.press, with: {{lives: {deaths}}}{retry}}}'}]\n"
    )
    ended = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "run", str(folder / "p.yaml"), "--lab",
         str(folder / "lab.yaml"), "--runs", str(folder / "runs")],
        capture_output=True, text=True,
    )  # fmt: skip
    assert list((folder / "runs").glob("*/journal.jsonl")), ended.stderr + ended.stdout
    (left,) = (folder / "runs").iterdir()
    records = list(read_records(left / "journal.jsonl"))
    return ended.returncode, [r for r in records if r.kind == "ended"], records[-1]


@pytest.mark.slow
def test_what_may_be_done_again_is_asked_for_again_without_a_retry(tmp_path):
    status, ended, _ = run(tmp_path, deaths=2)

    assert status == 0
    assert [(e.state, e.error and e.error.name) for e in ended] == [
        ("ABORTED", "Lost"), ("ABORTED", "Lost"), ("SUCCEEDED", None),
    ]  # fmt: skip


@pytest.mark.slow
def test_a_server_that_goes_on_dying_is_a_failure_of_the_step(tmp_path):
    status, ended, finished = run(tmp_path, deaths=99)

    assert status == 1
    assert [e.error.name for e in ended] == ["Lost"] * 4
    assert "Lost" in finished.detail


@pytest.mark.slow
@pytest.mark.parametrize("of_the_set", [False, pytest.param(True, marks=pytest.mark.soak)])
def test_with_a_retry_the_number_of_attempts_is_the_persons_also_of_those_that_are_lost(
    tmp_path, of_the_set
):
    press = "{do: m.press, with: {lives: 99}"
    steps = f"{{parallel: [{press}}}], retry: 2}}" if of_the_set else f"{press}, retry: 2}}"

    status, ended, _ = run(tmp_path, steps=steps)

    assert (status, [e.error.name for e in ended]) == (1, ["Lost"] * 2)


@pytest.mark.slow
@pytest.mark.parametrize("retry", ["", pytest.param(", retry: 3", marks=pytest.mark.soak)])
def test_what_may_have_happened_is_not_asked_for_again(tmp_path, retry):
    _, ended, _ = run(tmp_path, deaths=99, effect="once", retry=f"{retry}, on_unknown: skip")

    assert [e.error.name for e in ended] == ["Lost"]
    assert len(next(tmp_path.glob("runs/*/servers/world/deaths")).read_text()) == 1


ENDS_IN_ORDER = """
import asyncio, os, signal
from labrun.drivers.driver import Driver

class Mortal(Driver):
    contract = "mortal@1"

    async def press(self, goal, *, lives):
        ended = self.place.world / "ended"
        with (self.place.world / "presses").open("a") as file:
            file.write(str(lives))
        if lives == 1 and not ended.exists():
            ended.touch()
            os.kill(os.getpid(), signal.SIGTERM)
        return {}

    async def safe(self):
        await asyncio.sleep(2)
"""


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["once", pytest.param("idempotent", marks=pytest.mark.soak)])
def test_an_orderly_end_of_a_server_with_a_slow_safe_state_costs_no_step(tmp_path, effect):
    presses = ", ".join(f"{{do: m.press, with: {{lives: {n}}}}}" for n in (1, 2, 3))

    status, ended, _ = run(tmp_path, effect=effect, driver=ENDS_IN_ORDER, steps=presses)

    assert status == 0
    assert [e.error.name for e in ended if e.error is not None] in ([], ["Lost"])
    if effect == "idempotent":  # it may be done again
        return
    # Put back from before the second press was sent, to servers that remember all of it.
    (left,) = (tmp_path / "runs").iterdir()
    lines = (left / "journal.jsonl").read_text().splitlines(keepends=True)
    first = next(n for n, line in enumerate(lines) if '"kind":"ended"' in line)
    (left / "journal.jsonl").write_text("".join(lines[: first + 1]), newline="\n")
    subprocess.run([sys.executable, "-m", "labrun.engine", "resume", str(left)], check=True)

    assert (left / "servers" / "world" / "presses").read_text() == "123"
