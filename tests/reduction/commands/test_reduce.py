"""`labrun reduce`, through its command line: real files, real processes, a real terminal."""

import csv
import gzip
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

LABRUN = [sys.executable, "-m", "labrun.engine"]
ENVIRONMENT = {**os.environ, "COLUMNS": "100"}
posix = pytest.mark.skipif(os.name == "nt", reason="signals and terminals of POSIX")


def reduce(*arguments, jobs: int = 1) -> subprocess.CompletedProcess:
    return subprocess.run(
        [*LABRUN, "reduce", "--jobs", str(jobs), *map(str, arguments)],
        capture_output=True, text=True, env=ENVIRONMENT,
    )  # fmt: skip


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_a_folder_is_reduced_into_tables_beside_it(spectra, tmp_path):
    (spectra / "empty.csv").write_text("")
    (spectra / "photo.jpg").write_bytes(b"\xff")
    done = reduce(spectra, jobs=2)
    out = tmp_path / "reduced"

    assert done.returncode == 3, done.stderr  # six are reduced, one failed
    assert "skipped: photo.jpg" in done.stderr
    assert "6 spectra reduced" in done.stdout
    assert (
        "1 could not be reduced" in done.stdout
        and "empty.csv: the spectrum is empty" in done.stdout
    )
    assert len(rows(out / "files.csv")) == 7
    assert (out / "overview.png").stat().st_size > 10_000
    assert [path.name for path in out.iterdir() if path.name.startswith(".")] == []


@pytest.mark.parametrize(
    ("reader", "begins"),
    [
        ("h5py", b"\x89HDF\r\n\x1a\n"), ("sif_parser", b"Andor Technology Multi-Channel File"),
        ("avaread", b"AVS84"), ("spc_io", b"\0K\0\x80"),
        ("python_calamine", b"PK\3\4" + bytes(22) + b"\3\0\0\0xl/"),
    ],
    ids=("h5py", "sif_parser", "avaread", "spc_io", "calamine"),
)  # fmt: skip
@pytest.mark.parametrize(
    "words",
    [
        ("reduce", "one.h5"), ("reduce", "folder"), ("reduce", "one.h5.gz"), ("spectrum", "one.h5"),
        ("calibrate", "response", "good.csv", "one.h5"),
        ("calibrate", "standards", "table.csv", "good.csv", "one.h5"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_a_format_whose_reader_is_not_installed_is_told_before_anything_is_reduced(
    labrun, tmp_path, shots, reader, begins, words, monkeypatch
):
    raw = begins + bytes(600)
    (tmp_path / "folder").mkdir()
    for name in ("one.h5", "folder/two.sif"):
        (tmp_path / name).write_bytes(raw)
    (tmp_path / "one.h5.gz").write_bytes(gzip.compress(raw))
    (tmp_path / "good.csv").write_bytes(shots[0])
    (tmp_path / "table.csv").write_text("sample,Li (ppm)\ngood,5\none,10\n")
    monkeypatch.setitem(sys.modules, reader, None)
    # As if every process and every kernel took for ever.
    monkeypatch.setattr("labrun.reduction.batch.pool.Pool.call_up", lambda pool: None)
    monkeypatch.setattr("labrun.reduction.batch.batch.Batch.add", None)
    monkeypatch.setattr("labrun.reduction.reduce.reduce_spectrum", None)
    done = labrun(*words)

    assert done.returncode == 2, done.stderr
    assert f"its reader {reader} is not installed; add it with: " in done.stderr
    assert '"labrun[formats]"' in done.stderr


@pytest.mark.soak
def test_a_run_is_reduced_again_with_other_elements(spectra, tmp_path):
    run = tmp_path / "2026-11-21_map_7f3a"
    run.mkdir()
    (run / "run.json").write_text("{}")
    spectra.rename(run / "spectra")
    done = reduce(run, "--elements", "na, li", "--medium", "air", "--no-figures")
    found = rows(run / "reduced" / "elements.csv")

    assert done.returncode == 0, done.stderr
    assert {row["element"] for row in found} == {"Na", "Li"}
    assert found[0]["spectrum"] == "spectra/core_0.csv"
    assert not (run / "reduced" / "overview.png").exists()


@pytest.mark.soak
def test_a_single_file_in_angstrom_is_reduced(spectra, shots):
    lines = shots[0].decode().splitlines()[1:]
    pairs = (line.split(",") for line in lines)
    path = spectra / "angstrom.csv"
    path.write_text("".join(f"{10 * float(x):.3f},{y}\n" for x, y in pairs))

    refused = reduce(path)

    assert refused.returncode == 1 and "--unit angstrom" in refused.stdout
    assert reduce(path, "--unit", "angstrom").returncode == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["missing"], "missing does not exist, and no run in runs is called so"),
        (["."], "no spectrum found in ."),
        ([".", "--jobs", "0"], "--jobs 0: at least one"),
        ([".", "--medium", "oil"], "choose air or vacuum"),
        ([".", "--unit", "inch"], "choose nm, angstrom"),
        ([".", "--elements", "Li,Xx"], "no lines of 'Xx'"),
        ([".", "--elements", " , "], "write symbols"),
        ([".", "--until-idle", "3"], "needs --watch"),
        ([".", "--closure", "oxide"], "--closure oxide: choose oxides or elements"),
        ([".", "--closure", "oxides", "--calibration", "x.json"], "choose one"),
        (["file.txt", "--watch"], "needs a folder to watch"),
        ([".", "-o", "file.txt"], "file.txt is a file"),
        ([".", "-o", "theirs"], "theirs holds peaks.csv"),
    ],
)
def test_wrong_usage_is_a_sentence_and_changes_nothing(tmp_path, labrun, arguments, words):
    (tmp_path / "file.txt").write_text("notes, no spectrum\n")
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "peaks.csv").write_text("spectrum,mine\n")
    if arguments[-1] in ("theirs", "file.txt"):
        (tmp_path / "s.csv").write_text("200,1\n")
    done = labrun("reduce", *arguments)

    assert done.returncode == 2, done.stderr
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / "theirs" / "peaks.csv").read_text() == "spectrum,mine\n"


@pytest.mark.slow
def test_where_nothing_could_be_reduced_the_status_says_so(tmp_path):
    (tmp_path / "empty.csv").write_text("")
    done = reduce(tmp_path / "empty.csv", "-o", tmp_path / "out")

    assert done.returncode == 1
    assert rows(tmp_path / "out" / "files.csv")[0]["status"] == "failed"


def in_dialect(shot: bytes, form: str) -> bytes:
    """A spectrum as another program writes it."""
    pairs = [line.split(",") for line in shot.decode().splitlines()[1:]]
    return "".join(form.format(x, y) for x, y in pairs).encode()


@pytest.mark.soak
def test_a_folder_of_many_programs_loses_none_and_says_what_it_noticed(spectra, shots, tmp_path):
    folder = tmp_path / "many programs, one folder"
    folder.mkdir()
    german = in_dialect(shots[0], "{}|{}\n").replace(b".", b",").replace(b"|", b";")
    (folder / "a german.csv").write_bytes("Wellenlänge;Zähler\n".encode("cp1252") + german)
    (folder / "b suite.txt").write_bytes(
        b"SpectraSuite Data File\n++++\n>>>>>Begin Processed Spectral Data<<<<<\n"
        + in_dialect(shots[0], "{}\t{}\n") + b">>>>>End Processed Spectral Data<<<<<\n"
    )  # fmt: skip
    (folder / "c plain.csv.gz").write_bytes(gzip.compress(shots[0]))
    (folder / "d three.csv").write_bytes(in_dialect(shots[0], "{0},{1},{1},{1}\n"))
    half = shots[0].index(b",", len(shots[0]) // 2)  # its last row has no count
    (folder / "e half.csv").write_bytes(shots[0][:half])
    (folder / "f zeros.csv").write_bytes(in_dialect(shots[0], "{},0\n"))
    (folder / "g pixel.csv").write_bytes(b"pixel,raw\n" + in_dialect(shots[0], "{},{}\n"))
    (folder / "h archive.zip").write_bytes(b"PK\x03\x04\0\0")
    done = reduce(folder, "-o", tmp_path / "out", "--no-figures")
    files = {row["spectrum"]: row for row in rows(tmp_path / "out" / "files.csv")}
    peaks = rows(tmp_path / "out" / "peaks.csv")
    of = {name: [r["area"] for r in peaks if r["spectrum"] == name] for name in files}

    assert done.returncode == 3, done.stderr
    assert [row["status"] for row in files.values()] == ["reduced"] * 4 + ["failed"] * 3
    assert of["a german.csv"] == of["b suite.txt"] == of["c plain.csv.gz"] == of["d three.csv"]
    assert files["a german.csv"]["notes"] == "decimal commas"
    assert files["d three.csv"]["notes"].startswith("3 columns without headings are read as shots")
    assert files["d three.csv"]["notes"].endswith("; the mean of 3 shots")
    assert "note: d three.csv: 3 columns without headings" in done.stdout
    assert "f zeros.csv: every intensity is 0" in done.stdout
    assert "skipped: h archive.zip (an archive; unpack it)" in done.stderr


def test_a_folder_without_spectra_is_told_with_what_is_in_it(tmp_path, labrun):
    (tmp_path / "empty folder").mkdir()
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    for n in range(12):
        (pictures / f"{n}.png").write_bytes(b"\x89PNG")
    empty, images = labrun("reduce", tmp_path / "empty folder"), labrun("reduce", pictures)

    assert (empty.returncode, images.returncode) == (2, 2)
    assert "empty folder: it is empty" in empty.stderr
    assert "skipped: 0.png, 1.png, 2.png and 9 more (a spectrum has one of" in images.stderr
    assert "none of its 12 files may be one" in images.stderr


@pytest.mark.soak
def test_columns_may_be_said_where_none_fits(shots, tmp_path):
    path = tmp_path / "odd.csv"
    path.write_bytes(b"a,b,c\n" + in_dialect(shots[0], "7,{},{}\n"))
    plain = tmp_path / "plain.csv"
    plain.write_bytes(shots[0])
    wrong = reduce(path, "--columns", "2,9", "-o", tmp_path / "out")
    done = reduce(path, plain, "--columns", "b,c", "-o", tmp_path / "out", "--no-figures")

    assert wrong.returncode == 1 and "no column 9; the table has 3" in wrong.stdout
    assert done.returncode == 3 and "plain.csv: --columns: no columns are headed 'b'" in done.stdout


@pytest.mark.soak
def test_one_bad_file_among_1071_is_named_and_the_others_are_reduced(many, shots, tmp_path):
    for copy in range(470):
        os.link(many / "s_0.csv", many / f"t_{copy}.csv")
    (many / "s_0_50.csv").unlink()
    (many / "s_0_50.csv").write_bytes(shots[0][:-3].replace(b",", b";", 40) + b"\n251.6;half")
    (many / "last.csv").write_bytes(shots[0])
    done = reduce(many, "-o", tmp_path / "out", "--no-figures")
    failed = [r for r in rows(tmp_path / "out" / "files.csv") if r["status"] == "failed"]

    assert done.returncode == 3, done.stderr
    assert "1 could not be reduced" in done.stdout and "s_0_50.csv: line" in done.stdout
    assert "1,070 spectra reduced" in done.stdout
    assert [row["spectrum"] for row in failed] == ["s_0_50.csv"]


@pytest.mark.slow
def test_a_scheduler_that_is_not_there_is_a_sentence(spectra):
    pytest.importorskip("distributed")
    done = reduce(spectra, "--dask", "nonsense")

    assert done.returncode == 4
    assert done.stderr.startswith("labrun: no dask scheduler answers at nonsense")


def started(*arguments) -> subprocess.Popen:
    return subprocess.Popen(
        [*LABRUN, "reduce", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True, env=ENVIRONMENT,
    )  # fmt: skip


def some_rows(out: Path) -> None:
    """Wait until the first spectra are on the disk."""
    ends = time.monotonic() + 90
    while time.monotonic() < ends:
        if any(path.stat().st_size for path in out.glob(".reducing-*/rows")):
            return
        time.sleep(0.05)
    raise AssertionError("no spectrum was reduced")


def group_is_gone(pid: int) -> bool:
    """Whether nothing is left of a process and its children, a second later at the latest."""
    ends = time.monotonic() + 5
    while time.monotonic() < ends:
        try:
            os.killpg(pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.slow
@posix
@pytest.mark.parametrize(
    ("number", "status", "words"),
    [
        ("SIGINT", 130, "stopped after"),
        pytest.param("SIGTERM", 143, "terminated; no table was changed", marks=pytest.mark.soak),
    ],
)
def test_ctrl_c_and_sigterm_end_it_with_a_sentence_and_without_orphans(
    many, tmp_path, number, status, words
):
    out = tmp_path / "out"
    run = started(many, "-o", out, "--jobs", "2")
    some_rows(out)
    if number == "SIGINT":  # from the keyboard it comes to all processes of the group
        os.killpg(run.pid, signal.SIGINT)
    else:
        run.terminate()
    _, told = run.communicate()

    assert run.returncode == status, told
    assert words in told
    assert "Traceback" not in told
    assert group_is_gone(run.pid)
    assert not out.exists()


@pytest.mark.slow
@posix
def test_when_it_is_killed_its_workers_end_by_themselves(many, tmp_path):
    out = tmp_path / "out"
    run = started(many, "-o", out, "--jobs", "2")
    some_rows(out)
    run.kill()
    run.communicate()

    assert group_is_gone(run.pid)


@pytest.mark.slow
@posix
def test_a_watch_takes_what_comes_and_ctrl_c_ends_it_with_its_tables(tmp_path, shots):
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    run = started(folder, "-o", out, "--watch", "--no-figures")
    (folder / "a.csv").write_bytes(shots[0])
    ends = time.monotonic() + 90
    while not (out / "files.csv").exists() and time.monotonic() < ends:
        time.sleep(0.1)
    os.killpg(run.pid, signal.SIGINT)
    said, told = run.communicate()

    assert run.returncode == 0, told
    assert "watching; Ctrl-C ends it" in told
    assert "1 spectra reduced" in said
    assert [row["spectrum"] for row in rows(out / "files.csv")] == ["a.csv"]
    assert group_is_gone(run.pid)


@pytest.mark.soak
def test_a_watch_ends_when_nothing_comes_any_more(spectra, tmp_path):
    done = reduce(spectra, "-o", tmp_path / "out", "--watch", "--until-idle", "1", "--no-figures")

    assert done.returncode == 0, done.stderr
    assert len(rows(tmp_path / "out" / "files.csv")) == 6


@pytest.mark.soak
@posix
def test_in_a_terminal_there_is_a_bar(spectra, tmp_path):
    import pty

    ours, theirs = pty.openpty()
    run = subprocess.Popen(
        [*LABRUN, "reduce", str(spectra), "-o", str(tmp_path / "out"), "--no-figures"],
        stdin=theirs, stdout=theirs, stderr=theirs, env={**ENVIRONMENT, "TERM": "xterm"},
    )  # fmt: skip
    os.close(theirs)
    told = b""
    while True:
        try:
            piece = os.read(ours, 4096)
        except OSError:
            break
        if not piece:
            break
        told += piece
    os.close(ours)

    assert run.wait(30) == 0, told
    assert b"reducing" in told and b"6/6" in told
    assert b"6 spectra reduced" in told


@pytest.mark.soak
@pytest.mark.timeout(300)
def test_the_first_reduction_after_an_install_says_that_it_compiles(spectra, tmp_path):
    for path in sorted(spectra.iterdir())[1:]:
        path.unlink()
    done = subprocess.run(
        [*LABRUN, "reduce", str(spectra), "-o", str(tmp_path / "out"), "--no-figures"],
        capture_output=True, text=True,
        env={**ENVIRONMENT, "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert "compiling the loops of the fits, on first use of this version only" in done.stderr
