import os

import pytest

from labrun.reduction.batch.looks import BEGINNING, not_a_spectrum

ROWS = "200.0,5\n200.1,6\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "wavelength,intensity\n" + ROWS),
        ("a.csv", "Wavelength (nm);Counts\n200;5\n"),
        ("a.csv", '"wavelength","intensity"\n' + ROWS),
        ("a.csv", "sample 7,shot 3\n" + ROWS),
        ("a.csv", ROWS),
        ("a.tsv", "# a comment\n\n200\t5\n"),
        ("a.txt", "Spectrometer: X\nIntegration: 3\n" + ROWS.replace(",", " ")),
        ("a.dat", "200 5\n"),
        ("A.CSV", ROWS),
        ("a.csv", ""),
        ("a.csv", "wavelength,intensity\n"),
        ("a.csv", "1\n2\n3\n"),
        ("a.csv", "nan,5\n"),
        ("a.csv", "pixel,intensity\n0,5\n"),
        ("a.npy", "not looked into"),
        ("a.jdx", "##TITLE=x\n"),
        ("a.SSM", ROWS),
        ("a.csv", "wavelength,intensity\n" + "200.000,5\n" * BEGINNING),
    ],
)
def test_what_may_be_a_spectrum_is_taken(tmp_path, name, text):
    (tmp_path / name).write_text(text)

    assert not_a_spectrum(tmp_path / name) is None


def test_what_is_no_text_at_all_is_a_spoiled_spectrum(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe\x80\x81")

    assert not_a_spectrum(tmp_path / "a.csv") is None


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("data.csv", 'key,x_mm,y_mm,shot,Li\n"0,0",0,0,1,5\n', "not a spectrum's header: 'key,"),
        ("peaks.csv", "spectrum,center_nm,area\na.csv,200,5\n", "not a spectrum's header"),
        ("notes.txt", "This is what we did.\nThen we did more.\n", "not a spectrum's header"),
        ("photo.jpg", "", "a spectrum has one of the suffixes .asc .csv"),
        ("Makefile", "", "a spectrum has one of the suffixes"),
        (".a.csv", ROWS, "hidden"),
    ],
)
def test_what_is_clearly_something_else_is_left_aside_with_its_reason(tmp_path, name, text, reason):
    (tmp_path / name).write_text(text)

    assert reason in not_a_spectrum(tmp_path / name)


@pytest.mark.posix("it has no such named pipes")
def test_a_named_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.csv")

    assert "pipe" in not_a_spectrum(tmp_path / "a.csv")
