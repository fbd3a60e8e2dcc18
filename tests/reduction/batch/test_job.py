"""Tables in the making: the same bytes from any number of workers, and nothing half done."""

import csv
import hashlib
import json

import pyarrow.parquet as pq
import pytest

from labrun.reduction.batch.batch import Batch
from labrun.reduction.batch.gather import gather
from labrun.reduction.batch.job import NotOurs, job_in
from labrun.reduction.batch.pool import Pool
from labrun.reduction.batch.settings import Settings
from labrun.reduction.batch.summary import Circumstances
from labrun.reduction.tables.columns import TABLES
from labrun.reduction.tables.write import file_names


def reduce_into(out, folder, jobs, settings=None):
    settings = settings or Settings()
    found = gather([folder], out)
    about = Circumstances(settings, f"{jobs} processes", folder, found.left_aside)
    pool = Pool(jobs, settings, lambda: None)
    try:
        with job_in(out, about) as job:
            batch = Batch(pool, job.spool)
            batch.add(found.spectra)
            batch.run()
            return job.write()
    finally:
        pool.close()


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def mixed(spectra):
    """Six spectra and four files that are none."""
    (spectra / "empty.csv").write_text("")
    (spectra / "text, quoted.csv").write_text('wavelength,intensity\n200,"oops"\n')
    (spectra / "zeros.csv").write_text("200,0\n201,0\n202,0\n")
    (spectra / "notes.md").write_text("no spectrum")
    return spectra


@pytest.mark.slow
def test_tables_are_the_same_bytes_for_any_number_of_workers(mixed, tmp_path, tables_of):
    for jobs in (1, 2):
        reduce_into(tmp_path / f"out{jobs}", mixed, jobs)
    one, two = (tables_of(tmp_path / f"out{jobs}") for jobs in (1, 2))

    assert one == two


@pytest.mark.slow
def test_every_file_has_one_row_with_its_reason_and_csv_and_parquet_say_the_same(mixed, tmp_path):
    out = tmp_path / "out"
    counts = reduce_into(out, mixed, 2)
    files = rows(out / "files.csv")

    assert [row["spectrum"] for row in files] == [
        "core_0.csv", "core_2.csv", "core_4.csv", "core_6.csv", "core_8.csv", "core_10.csv",
        "empty.csv", "text, quoted.csv", "zeros.csv",
    ]  # fmt: skip
    assert [row["status"] for row in files] == ["reduced"] * 6 + ["failed"] * 3
    assert "empty" in files[6]["reason"]
    assert files[7]["reason"] == "line 2 is not two numbers: '200,\"oops\"'"
    assert (counts.reduced, len(counts.failed)) == (6, 3)
    for table, columns in TABLES.items():
        read = pq.read_table(out / f"{table}.parquet")
        text = rows(out / f"{table}.csv")

        assert read.column_names == [column.name for column in columns] == list(text[0])
        assert len(read) == len(text)
        for column in columns:
            for cell, value in zip(text, read[column.name].to_pylist(), strict=True):
                same = cell[column.name] == ("" if value is None else str(value))
                assert same or float(cell[column.name]) == value


@pytest.mark.soak
def test_only_the_elements_asked_for_get_a_row(spectra, tmp_path):
    reduce_into(tmp_path / "out", spectra, 2, Settings(elements=("Li", "Cs", "K")))

    assert [row["element"] for row in rows(tmp_path / "out" / "elements.csv")][:3] == [
        "Li", "Cs", "K",
    ]  # fmt: skip


@pytest.mark.slow
def test_the_summary_tells_inputs_versions_configuration_and_times(mixed, tmp_path):
    out = tmp_path / "out"
    reduce_into(out, mixed, 1, Settings(elements=("Li",), medium="air"))
    told = json.loads((out / "summary.json").read_text())
    first = (mixed / "core_0.csv").read_bytes()

    assert told["inputs"][0] == {
        "spectrum": "core_0.csv",
        "bytes": len(first),
        "sha256": hashlib.sha256(first).hexdigest(),
    }
    assert {"labrun", "python", "numpy", "numba", "scipy", "pyarrow"} <= set(told["versions"])
    assert told["configuration"] == {
        "elements": ["Li"], "medium": "air", "unit": None, "columns": None, "lines_sha256": None,
        "response_sha256": None, "calibration_sha256": None, "closure": None,
    }  # fmt: skip
    assert told["counts"]["spectra"] == 9
    assert told["notes"] == []
    assert told["left_aside"][0]["file"] == "notes.md"
    assert told["timings"]["seconds"] > 0


@pytest.mark.soak
def test_an_earlier_reduction_is_replaced_and_nothing_else_is_touched(spectra, tmp_path):
    out = tmp_path / "out"
    reduce_into(out, spectra, 1)
    (out / "mine.txt").write_text("keep this")
    before = (out / "peaks.csv").read_bytes()
    for path in list(spectra.iterdir())[1:]:
        path.unlink()
    reduce_into(out, spectra, 1)

    assert (out / "peaks.csv").read_bytes() != before
    assert len(rows(out / "files.csv")) == 1
    assert sorted(path.name for path in out.iterdir()) == sorted(
        [*file_names(), "summary.json", "mine.txt"]
    )


@pytest.mark.slow
def test_what_was_begun_and_not_finished_leaves_the_tables_as_they_were(spectra, tmp_path):
    out = tmp_path / "out"
    reduce_into(out, spectra, 1)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    about = Circumstances(Settings(), "", spectra)

    with pytest.raises(KeyboardInterrupt), job_in(out, about):
        raise KeyboardInterrupt

    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_tables_of_somebody_else_are_not_overwritten(tmp_path):
    (tmp_path / "peaks.csv").write_text("mine")
    about = Circumstances(Settings(), "", tmp_path)

    with pytest.raises(NotOurs, match=r"holds peaks\.csv"), job_in(tmp_path, about):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["peaks.csv"]


def test_a_file_cannot_be_the_folder_for_tables(tmp_path):
    (tmp_path / "out").write_text("")
    about = Circumstances(Settings(), "", tmp_path)

    with pytest.raises(NotOurs, match="is a file"), job_in(tmp_path / "out", about):
        pass
