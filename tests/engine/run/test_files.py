"""Files of a run stay in its folder, whole, and are what their hash says."""

from hashlib import sha256

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.engine.run.files import read_content, write_content
from labrun.engine.run.names import FileFault, inside
from labrun.schemas.messages import FileContent


def content(path, data=b"abc"):
    return FileContent(path=path, sha256=sha256(data).hexdigest(), data=data)


def test_what_is_written_is_read_again(tmp_path):
    write_content(tmp_path, content("spectra/a.csv"))

    assert read_content(tmp_path, "spectra/a.csv").data == b"abc"


@pytest.mark.parametrize(
    "name", ["../x", "/etc/passwd", "a/../../x", "", ".", "./", "C:\\x", "..\\x", "a\0b"]
)
def test_a_name_that_leads_out_of_the_folder_is_refused(tmp_path, name):
    with pytest.raises(FileFault, match="not a file name inside"):
        inside(tmp_path, name)


@pytest.mark.parametrize(
    "name",
    [
        "spectra/11:30.csv", "nul.csv", "Con", "spectra/aux .csv", "com1.txt", "lpt³", "what?.csv",
        "a./b.csv", "spectra/point 1 ", "<a>", "a\tb",
    ],
)  # fmt: skip
def test_a_name_that_no_file_has_on_windows_is_refused_there_before_anything_is_done(
    tmp_path, monkeypatch, name
):
    # `open("11:30.csv")` writes a hidden stream of the file `11`, and `nul.csv` is nowhere.
    monkeypatch.setattr("labrun.engine.run.names.WINDOWS", False)
    assert inside(tmp_path, name)
    monkeypatch.setattr("labrun.engine.run.names.WINDOWS", True)

    with pytest.raises(FileFault, match="on Windows no file can be named"):
        inside(tmp_path, name)


@pytest.mark.parametrize(
    "name", ["spectra/point_1.csv", "null.csv", "com10.txt", ".hidden", "a.b c"]
)
def test_a_usual_name_is_one_on_windows(tmp_path, monkeypatch, name):
    monkeypatch.setattr("labrun.engine.run.names.WINDOWS", True)

    assert inside(tmp_path, name) == tmp_path / name


@given(st.text(max_size=20))
def test_no_name_whatever_leads_out_of_the_folder(tmp_path_factory, name):
    folder = tmp_path_factory.getbasetemp() / "run"
    try:
        place = inside(folder, name)
    except FileFault:
        return
    assert folder in (place, *place.parents)


def test_a_damaged_file_is_refused_and_nothing_is_left(tmp_path):
    bad = FileContent(path="a.csv", sha256="0" * 64, data=b"abc")

    with pytest.raises(FileFault, match="damaged"):
        write_content(tmp_path, bad)

    assert list(tmp_path.iterdir()) == []


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileFault, match=r"a\.csv is not in the run's folder"):
        read_content(tmp_path, "a.csv")
