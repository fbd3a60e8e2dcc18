"""Real processes: shared work, killed workers, workers that hang, and the end of it all."""

import os
import signal
import time
from multiprocessing import Pipe
from pathlib import Path

import pytest

from labrun.reduction.batch.batch import Batch
from labrun.reduction.batch.executor import ExecutorFault
from labrun.reduction.batch.pool import COMPILING_S, Pool, _Worker, cores, how_it_ended
from labrun.reduction.batch.settings import Settings
from labrun.reduction.batch.source import Source
from labrun.reduction.batch.spool import Spool
from labrun.reduction.batch.worker import COMPILING, UP

SIGKILL = getattr(signal, "SIGKILL", None)
pytestmark = pytest.mark.skipif(SIGKILL is None, reason="signals of POSIX")


class Struck(Pool):
    """A pool whose process gets a signal right after it was given a certain spectrum."""

    victim, blows, blow = "", 0, SIGKILL

    def start(self, number, chunk):
        super().start(number, chunk)
        if self.blows and any(self.victim in source.name for source in chunk):
            self.blows -= 1
            worker = next(w for w in self.workers if w.number == number)
            os.kill(worker.process.pid, self.blow)


def reduced(pool, folder: Path, tmp_path: Path):
    sources = [Source(path.name, path) for path in sorted(folder.iterdir())]
    spool = Spool(tmp_path / "rows")
    batch = Batch(pool, spool)
    try:
        batch.add(sources)
        batch.run()
    finally:
        pids = [worker.process.pid for worker in pool.workers]
        pool.close()
        spool.close()
    return {done.name: done.reason for done in spool.done()}, pids


def gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.mark.slow
def test_several_processes_share_the_work_and_are_gone_afterwards(spectra, tmp_path):
    outcome, pids = reduced(Pool(2, Settings(), lambda: None), spectra, tmp_path)

    assert list(outcome.values()) == [""] * 6
    assert len(pids) == 2
    assert all(gone(pid) for pid in pids)


@pytest.mark.soak
def test_a_killed_worker_costs_nothing_but_time(spectra, tmp_path):
    pool = Struck(1, Settings(), lambda: None)
    pool.victim, pool.blows = "core_4", 1
    outcome, _ = reduced(pool, spectra, tmp_path)

    assert sorted(outcome) == sorted(path.name for path in spectra.iterdir())
    assert set(outcome.values()) == {""}


@pytest.mark.slow
def test_the_spectrum_that_kills_its_worker_twice_is_told_and_the_others_are_reduced(
    spectra, tmp_path
):
    pool = Struck(2, Settings(), lambda: None)
    pool.victim, pool.blows = "core_4", 2
    outcome, _ = reduced(pool, spectra, tmp_path)

    assert outcome.pop("core_4.csv") == (
        "the process that reduced it was killed by SIGKILL (out of memory?), twice"
    )
    assert set(outcome.values()) == {""}


@pytest.mark.slow
@pytest.mark.posix("Windows has no such signal")
def test_a_worker_that_hangs_is_ended_and_its_spectrum_tried_again(spectra, tmp_path):
    pool = Struck(1, Settings(), lambda: None, chunk_s=25.0)
    pool.victim, pool.blows, pool.blow = "core_0", 1, signal.SIGSTOP
    pool.chunk_s = 2.0

    def start(number, chunk):
        Struck.start(pool, number, chunk)
        pool.chunk_s = 60.0  # for those that come after

    pool.start = start
    outcome, _ = reduced(pool, spectra, tmp_path)

    assert set(outcome.values()) == {""}
    assert pool.blows == 0


def test_when_no_process_comes_up_it_is_said_instead_of_tried_for_ever(spectra, tmp_path):
    pool = Struck(1, Settings(), lambda: None)
    pool.victim, pool.blows = "core", 1000

    with pytest.raises(
        ExecutorFault, match=r"no reduction process starts, 3 times in a row; .* by SIGKILL"
    ):
        reduced(pool, spectra, tmp_path)


def test_compiling_costs_a_chunk_none_of_its_time_nor_one_that_waits_for_it():
    here, there = Pipe()
    pool, began = Pool(2, Settings(), lambda: None, chunk_s=10.0), time.monotonic()
    pool.workers = [_Worker(None, here, number=n, ends=began + 10.0) for n in range(2)]
    for what in (COMPILING, UP, COMPILING):
        there.send((what,))
        pool._heard(pool.workers[0])

    assert [w.ends - began for w in pool.workers] == pytest.approx([10.0 + COMPILING_S] * 2)


def test_the_ends_of_processes_have_words():
    assert how_it_ended(1) == "ended with status 1"
    assert how_it_ended(-11) == "was killed by SIGSEGV"
    assert how_it_ended(-9) == "was killed by SIGKILL (out of memory?)"
    assert how_it_ended(-64) == "was killed by SIGRTMAX" or "signal 64" in how_it_ended(-64)
    assert cores() >= 1


def test_the_environment_is_as_before_when_workers_have_started(spectra, tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    hears = signal.getsignal(signal.SIGINT)
    reduced(Pool(1, Settings(), lambda: None), spectra, tmp_path)

    assert os.environ["OMP_NUM_THREADS"] == "3"
    assert "NUMBA_NUM_THREADS" not in os.environ
    assert signal.getsignal(signal.SIGINT) is hears
