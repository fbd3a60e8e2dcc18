"""Histories by their seeds: the promise holds in them, and a planted fault is found and found again."""

import subprocess
import sys
from random import Random

import pytest

from labrun.drivers.server.ledger import Ledger
from labrun.engine.check import check_file
from labrun.engine.dispatch import dispatcher
from labrun.engine.simulation import disk
from labrun.engine.simulation.simulate import histories
from labrun.engine.tree.nodes import loop

SHOOT = """
labrun: 1
name: shoot
devices: {libs: libs_analyzer@1, balance: balance@1}
steps:
  - foreach: {i: [1, 2]}
    steps:
      - {do: balance.tare}
      - {id: shoot, do: libs.measure, timeout: 60 s}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: "s/${{ i }}.csv"}, timeout: 60 s}
finally: [{do: libs.disarm, on_error: continue}]
"""
SEEN = {"ledger": 20, "disk": 100, "journal": 100, "finished": 140, "probe": 600}
"""Where each planted fault is first found: those before it take long."""


async def believed(request, outcome, *more):
    return outcome


def first_broken(seeds):
    return next((outcome for outcome in histories(seeds) if outcome.breaches), None)


def test_a_few_histories_keep_the_promise():
    assert [o.breaches for o in histories(range(20)) if o.breaches] == []


def test_a_wait_that_is_over_within_the_rounding_of_the_clock_ends():
    (outcome,) = histories(range(10_445, 10_446))  # once it waited on and on at one moment

    assert outcome.breaches == []


def test_a_person_reads_off_what_later_steps_need_and_a_device_may_have_no_safe_state(tmp_path):
    (tmp_path / "shoot.yaml").write_text(SHOOT)
    told = list(histories(range(24), check_file(tmp_path / "shoot.yaml")))

    assert [o.breaches for o in told if o.breaches] == []
    assert sum(o.accidents["questions to a person"] for o in told) > 0


def test_a_seed_tells_everything_in_any_process():
    program = (
        "from labrun.engine.simulation.simulate import histories\n"
        "for outcome in histories(range(24, 28)): print(*outcome.story, sep='\\n')"
    )
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    story = [line for outcome in histories(range(24, 28)) for line in outcome.story]

    assert told.returncode == 0, told.stderr
    assert len(story) > 50
    assert told.stdout.splitlines() == story


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "said"),
    [
        ("a ledger that forgets what it has promised", "was done 2 times"),
        ("a disk at the server that syncs nothing", ""),
        ("a journal that syncs nothing", ""),
        ("what finished iterations had set is not set again", "instead of"),
        ("a probe that is believed beside an older ledger", "was done 2 times"),
    ],
)
def test_a_planted_fault_is_found_and_its_seed_finds_it_again(monkeypatch, plant, said):
    match plant.split():
        case ["a", "ledger", *_]:
            monkeypatch.setattr(Ledger, "has", lambda ledger, mark: True)
        case ["a", "disk", *_]:
            monkeypatch.setattr(disk.File, "sync", lambda file: None)
        case ["a", "journal", *_]:
            write = disk.SimulatedJournal._write
            unsynced = lambda self, data, *, sync=True: write(self, data, sync=False)  # noqa: E731
            monkeypatch.setattr(disk.SimulatedJournal, "_write", unsynced)
        case ["a", "probe", *_]:
            monkeypatch.setattr(dispatcher, "checked_with_server", believed)
        case _:
            monkeypatch.setattr(loop, "settings_of", lambda *given: [])

    found = first_broken(range(SEEN[plant.split()[1]], 1000))

    assert found is not None
    assert said in " ".join(found.breaches)
    (again,) = histories(range(found.seed, found.seed + 1))
    assert (again.breaches, again.story) == (found.breaches, found.story)


def test_of_what_was_not_synced_a_power_cut_keeps_any_sectors():
    kept = set()
    for seed in range(50):
        file = disk.File()
        file.write(b"a" * disk.SECTOR, 0)
        file.sync()
        file.write(b"b" * disk.SECTOR * 2, 0)
        file.lose(Random(seed))
        kept.add(tuple(bytes(file.data)[at : at + 1] for at in (0, disk.SECTOR)))

    assert kept == {(b"a", b""), (b"b", b""), (b"a", b"b"), (b"b", b"b")}
