"""What decides about a `once` action is what its device says of it, and nothing else.

The instrument here outlives every kill: what it does is written to a file that no server owns.
"""

import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from labrun.engine.journal.journal import read_records

DRIVER = """
import asyncio, os, shutil, signal
from pathlib import Path
from labrun.drivers.driver import Driver

class Gun(Driver):
    contract = "gun@1"

    async def fire(self, goal, *, n):
        self.done = Path(self.place.config["done"])
        for kept in self.done, self.place.folder / "own":
            with kept.open("a") as file:
                file.write(f"{n} {goal.id}\\n")
        async with asyncio.timeout(500):
            await self.after(n)
        return {"goal_id": goal.id}

    async def last_fired(self, goal):
        lines = self.memory().read_text().splitlines()
        return {"goal_id": lines[-1].split(" ", 1)[1] if lines else ""}

    def memory(self):
        return Path(self.place.config["done"])

    def dies(self):
        died = self.done.with_name("died")
        return not died.exists() and not died.touch()
"""
DIES_WITH_ITS_ENGINE = """
    async def after(self, n):
        ledger = self.place.folder.parent
        if n == 1:
            shutil.copytree(ledger, self.done.with_name("kept"))
        elif n == 2 and self.dies():
            journal = ledger.parents[1] / "journal.jsonl"
            while journal.read_text().count('"kind":"marked"') < 2:
                await asyncio.sleep(0.01)
            os.kill(os.getppid(), signal.SIGKILL)
            os.kill(os.getpid(), signal.SIGKILL)
"""
KEPT_AFTER_ONE = """
    async def after(self, n):
        run = self.place.folder.parents[2]
        if n == 1:
            shutil.copytree(run, self.done.with_name("kept"))
        elif n == 3 and self.dies():
            os.kill(os.getppid(), signal.SIGKILL)
            os.kill(os.getpid(), signal.SIGKILL)
"""
REMEMBERS_IN_ITS_FOLDER = """
    def memory(self):
        return self.place.folder / "own"
"""
DIES_AFTER_TWO = """
    async def after(self, n):
        while len(self.done.read_text().splitlines()) < 2:
            await asyncio.sleep(0.01)
        if self.dies():
            os.kill(os.getpid(), signal.SIGKILL)
"""
DIES_WITH_WHO_SERVES_IT = """
    async def after(self, n):
        if n == 2 and self.dies():
            os.kill(os.getppid(), signal.SIGKILL)
            os.kill(os.getpid(), signal.SIGKILL)
"""
ANOTHER_BENCH_FIRES = """
    async def after(self, n):
        if n == 2 and self.dies():
            with self.done.open("a") as file:
                file.write("9 elsewhere/main/shot/1\\n")
            os.kill(os.getpid(), signal.SIGKILL)
"""
CONTRACT = """
type: gun@1
concurrent: CONCURRENT
actions:
  fire:
    effect: once
    duration: 1 s
    PROBE
    params: {type: object, required: [n], properties: {n: {type: integer}}}
    returns: {type: object, required: [goal_id], properties: {goal_id: {type: string}}}
  last_fired:
    effect: pure
    duration: 1 s
    returns: {type: object, required: [goal_id], properties: {goal_id: {type: [string, "null"]}}}
"""


class Bench:
    """A folder with a gun, a protocol, and what the gun has done."""

    def __init__(self, folder: Path, after: str, steps: str, *, probe=True, concurrent=False):
        self.folder = folder
        (folder / "done").touch()
        (folder / "gun.py").write_text(DRIVER + after)
        (folder / "gun.yaml").write_text(
            CONTRACT.replace("CONCURRENT", str(concurrent).lower()).replace(
                "PROBE", "probe: last_fired" if probe else ""
            )
        )
        (folder / "lab.yaml").write_text(
            "name: armed\nsimulated: true\ncontracts: [./gun.yaml]\ndevices: {g: {contract: gun@1, "
            f"driver: './gun.py:Gun', config: {{done: '{folder / 'done'}'}}}}}}\n"
        )
        (folder / "p.yaml").write_text(
            f"labrun: 1\nname: p\ndevices: {{g: gun@1}}\nsteps: {steps}\n"
        )

    def labrun(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "labrun.engine", *words], cwd=self.folder, capture_output=True,
            text=True, stdin=subprocess.DEVNULL,
        )  # fmt: skip

    @property
    def run(self) -> Path:
        return next((self.folder / "runs").iterdir())

    @property
    def fired(self) -> list[str]:
        return [line.split()[0] for line in (self.folder / "done").read_text().splitlines()]

    def records(self, kind: str) -> list:
        return [r for r in read_records(self.run / "journal.jsonl") if r.kind == kind]

    def put_back_the_older_ledger(self) -> None:
        ledger = self.run / "servers" / "g"
        shutil.rmtree(ledger)
        shutil.copytree(self.folder / "kept", ledger)


@contextmanager
def served(bench: Bench, folder: str):
    """`labrun serve`, with its ledger in a folder; ended in order, if it has not ended before."""
    with subprocess.Popen(
        [sys.executable, "-m", "labrun.engine", "serve", "lab.yaml", "g", "--port", "0", "--folder",
         folder], cwd=bench.folder, stdout=subprocess.PIPE, text=True,
    ) as server:  # fmt: skip
        assert server.stdout is not None
        assert [server.stdout.readline() for _ in range(3)][2].startswith("serving")
        yield server
        server.terminate()


TWO = (
    "[{do: g.fire, with: {n: 1}}, {id: second, do: g.fire, with: {n: 2}}, "
    "{log: 'told ${{ steps.second.goal_id }}'}]"
)


def killed_in_the_second_shot(folder, driver=DIES_WITH_ITS_ENGINE, **more) -> Bench:
    bench = Bench(folder, driver, TWO, **more)
    bench.labrun("run", "p.yaml", "--lab", "lab.yaml")
    bench.put_back_the_older_ledger()
    return bench


@pytest.mark.slow
def test_a_ledger_that_went_back_in_time_denies_nothing_and_the_probe_is_asked(tmp_path):
    bench = killed_in_the_second_shot(tmp_path)

    ended = bench.labrun("resume", "last")

    assert (ended.returncode, bench.fired) == (0, ["1", "2"]), ended.stderr + ended.stdout
    assert [r.continues for r in bench.records("leased")] == [True, False]


@pytest.mark.slow
def test_a_driver_s_memory_that_went_back_with_the_ledger_denies_nothing(tmp_path):
    bench = killed_in_the_second_shot(tmp_path, DIES_WITH_ITS_ENGINE + REMEMBERS_IN_ITS_FOLDER)

    ended = bench.labrun("resume", "last", "--answer", "second=skip")

    assert bench.fired == ["1", "2"], ended.stderr + ended.stdout
    assert [r.choice for r in bench.records("answered")] == ["skip"]


@pytest.mark.slow
def test_without_a_probe_a_person_is_asked(tmp_path):
    bench = killed_in_the_second_shot(tmp_path, probe=False)

    ended = bench.labrun("resume", "last", "--answer", "second=skip")

    assert bench.fired == ["1", "2"], ended.stderr + ended.stdout
    assert [r.choice for r in bench.records("answered")] == ["skip"]
    assert [r.error.happened for r in bench.records("ended") if r.error] == ["unknown"]


@pytest.mark.slow
@pytest.mark.parametrize("marks", ["kept", "gone"])
def test_a_run_that_went_back_with_its_ledger_fires_nothing_again(tmp_path, monkeypatch, marks):
    (tmp_path / "marks").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "marks"))
    shots = ", ".join(f"{{id: shot_{n}, do: g.fire, with: {{n: {n}}}}}" for n in (1, 2, 3, 4))
    bench = Bench(tmp_path, KEPT_AFTER_ONE, f"[{shots}]")
    bench.labrun("run", "p.yaml", "--lab", "lab.yaml")
    run = bench.run
    shutil.rmtree(run)
    shutil.copytree(tmp_path / "kept", run)
    for noted in (tmp_path / "marks").glob("labrun_*") if marks == "gone" else ():
        noted.unlink()
    answers = ["shot_1=skip", "shot_2=skip", "shot_4=did_not_happen"]

    ended = bench.labrun("resume", "last", *(f"--answer={answer}" for answer in answers))

    assert (ended.returncode, bench.fired) == (0, ["1", "2", "3", "4"]), ended.stderr + ended.stdout
    assert "was put back from an older copy" in ended.stdout + ended.stderr
    assert [r.choice for r in bench.records("answered")] == ["skip", "skip", "did_not_happen"]


@pytest.mark.slow
def test_a_new_ledger_and_a_shot_by_hand_deny_none_of_ours(tmp_path):
    bench = Bench(tmp_path, DIES_WITH_WHO_SERVES_IT, TWO)
    with served(bench, "first") as server:
        engine = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", "run", "p.yaml", "--lab", "lab.yaml"],
            cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        server.wait()
    engine.kill()
    engine.wait()

    with served(bench, "second"):
        called = bench.labrun("call", "g.fire", "n=9", "--lab", "lab.yaml")
        ended = bench.labrun("resume", "last", "--answer", "second=skip")

    assert called.returncode == 0, called.stderr
    assert bench.fired == ["1", "2", "9"], ended.stderr + ended.stdout
    assert [r.choice for r in bench.records("answered")] == ["skip"]


@pytest.mark.slow
def test_an_engine_that_dies_once_more_before_it_has_asked_asks_all_the_same(tmp_path):
    bench = killed_in_the_second_shot(tmp_path, probe=False)
    with (bench.folder / "gun.py").open("a") as driver:
        driver.write("    async def open(self): os.kill(os.getppid(), signal.SIGKILL)\n")
    bench.labrun("resume", "last")
    (bench.folder / "gun.py").write_text(DRIVER + DIES_WITH_ITS_ENGINE)

    ended = bench.labrun("resume", "last", "--answer", "second=skip")

    assert bench.fired == ["1", "2"], ended.stderr + ended.stdout


@pytest.mark.slow
def test_on_a_concurrent_device_only_the_goals_own_id_proves_anything(tmp_path):
    both = "[{parallel: [{id: a, do: g.fire, with: {n: 1}}, {id: b, do: g.fire, with: {n: 2}}]}]"
    bench = Bench(tmp_path, DIES_AFTER_TWO, both, concurrent=True)

    ended = bench.labrun(
        "run", "p.yaml", "--lab", "lab.yaml", "--answer", "a=skip", "--answer", "b=skip"
    )

    assert sorted(bench.fired) == ["1", "2"], ended.stderr + ended.stdout
    assert len(bench.records("answered")) == 1


def answered(bench: Bench, *answers: str) -> tuple[list[subprocess.CompletedProcess[str]], int]:
    """Resume, give one answer after another once the question is asked, and wait for the end."""
    resumed = subprocess.Popen(
        [sys.executable, "-m", "labrun.engine", "resume", "last"], cwd=bench.folder,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    assert resumed.stdout is not None
    said = []
    for line in resumed.stdout:
        said.append(line)
        if line.startswith("?"):
            break
    else:
        raise AssertionError("".join(said))
    told = [bench.labrun("answer", "last", "second", *words.split()) for words in answers]
    resumed.communicate()
    return told, resumed.returncode


@pytest.mark.slow
def test_a_person_who_knows_that_it_happened_says_so_with_what_later_steps_need(tmp_path):
    bench = killed_in_the_second_shot(tmp_path, probe=False)

    (told,), status = answered(bench, "happened -r goal_id=seen")

    assert (told.returncode, status, bench.fired) == (0, 0, ["1", "2"]), told.stderr
    assert [(r.choice, r.result) for r in bench.records("answered")] == [
        ("happened", {"goal_id": "seen"})
    ]
    assert "told seen" in [r.result or r.message for r in bench.records("step")]


@pytest.mark.soak
def test_a_person_who_knows_that_it_did_not_happen_lets_it_be_done(tmp_path):
    bench = killed_in_the_second_shot(tmp_path, probe=False)

    (told,), status = answered(bench, "did_not_happen")

    assert (told.returncode, status, bench.fired) == (0, 0, ["1", "2", "2"]), told.stderr


@pytest.mark.soak
def test_an_answer_that_does_not_fit_is_refused_with_what_is_wrong(tmp_path):
    bench = killed_in_the_second_shot(tmp_path, probe=False)

    (missing, unknown, without, unwritten, stop), status = answered(
        bench, "happened", "happened -r shot=1 -r goal_id=x", "skip -r goal_id=x",
        "happened -r goal_id", "stop",
    )  # fmt: skip

    assert {t.returncode for t in (missing, unknown, without, unwritten)} == {2}
    assert "goal_id" in missing.stderr
    assert "shot" in unknown.stderr
    assert "'skip' takes no values: goal_id" in without.stderr
    assert "write -r NAME=VALUE" in unwritten.stderr
    assert (stop.returncode, status, bench.fired) == (0, 1, ["1", "2"])


@pytest.mark.slow
def test_a_shot_of_another_bench_with_the_same_instrument_denies_none_of_ours(tmp_path):
    bench = Bench(tmp_path, ANOTHER_BENCH_FIRES, TWO)

    bench.labrun("run", "p.yaml", "--lab", "lab.yaml", "--answer", "second=skip")

    assert bench.fired == ["1", "2", "9"]
    assert [r.id for r in bench.records("asked")] == ["second"]
