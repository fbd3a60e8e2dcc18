"""A folder that fills: what arrives is reduced, whole, and the tables grow."""

import csv
import shutil
import threading

import pytest

from labrun.reduction.batch.batch import Batch
from labrun.reduction.batch.job import job_in
from labrun.reduction.batch.pool import Pool
from labrun.reduction.batch.settings import Settings
from labrun.reduction.batch.summary import Circumstances
from labrun.reduction.batch.watch import Watch


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def watching(tmp_path):
    """A watch over an empty folder; `story(folder)` runs beside it, step by step."""
    folder, out = tmp_path / "folder", tmp_path / "out"
    folder.mkdir()
    pool = Pool(1, Settings(), lambda: None)

    def run(arrived, idle_s=2.0):
        with job_in(out, Circumstances(Settings(), "1 process", folder)) as job:
            batch = Batch(pool, job.spool)
            watch = Watch([folder], job, batch, lambda fresh, found: arrived(fresh), look_s=0.1)
            watch.run(until_idle_s=idle_s)

    yield folder, out, run
    pool.close()


@pytest.mark.slow
def test_what_arrives_is_reduced_and_a_changed_file_again(watching, shots):
    folder, out, run = watching
    told = []

    def arrived(fresh):
        told.extend(source.name for source in fresh)
        if not told and not (folder / "a.csv").exists():
            (folder / "a.csv").write_bytes(shots[0])
        elif fresh and told == ["a.csv"]:
            (folder / "b.csv").write_bytes(shots[1])
            (folder / "a.csv").write_bytes(shots[2])

    run(arrived)
    first = {row["spectrum"]: row["n_peaks"] for row in rows(out / "files.csv")}

    assert sorted(told) == ["a.csv", "a.csv", "b.csv"]
    assert set(first) == {"a.csv", "b.csv"}
    assert first["a.csv"] != "" and first["b.csv"] != ""


@pytest.mark.slow
def test_a_file_is_taken_when_it_has_stopped_growing(watching, shots):
    folder, out, run = watching
    slow = threading.Event()

    def write():
        with (folder / "a.csv").open("wb") as file:
            for at in range(0, len(shots[0]), 20_000):
                file.write(shots[0][at : at + 20_000])
                file.flush()
                slow.wait(0.03)

    writer = threading.Thread(target=write)
    writer.start()
    run(lambda fresh: None)
    writer.join()

    assert [row["status"] for row in rows(out / "files.csv")] == ["reduced"]


def test_a_folder_that_is_gone_for_a_while_is_looked_for_again(watching, shots):
    folder, out, run = watching
    looks = []

    def arrived(fresh):
        looks.append(len(fresh))
        if len(looks) == 1:
            shutil.rmtree(folder)
            threading.Timer(0.5, bring_back).start()

    def bring_back():
        folder.mkdir()
        (folder / "a.csv").write_bytes(shots[0])

    run(arrived)

    assert [row["spectrum"] for row in rows(out / "files.csv")] == ["a.csv"]


def test_a_watch_over_nothing_ends_and_leaves_no_tables(watching):
    _, out, run = watching
    run(lambda fresh: None, idle_s=0.5)

    assert not out.exists()
