"""`labrun calibrate response`, through its command line."""

import json

import numpy as np
import pytest


@pytest.fixture
def lamp(tmp_path):
    """Shots of a lamp whose light is level, seen by an instrument that sees half as much below 400 nm."""
    x = np.arange(300.0, 500.0, 0.1)
    seen = 1000 * np.where(x < 400, 0.5, 1.0)
    for name, counts in (("lamp", seen + 50.5), ("dark", 50 + np.arange(len(x)) % 2)):
        rows = "".join(f"{at:.2f},{one:.1f}\n" for at, one in zip(x, counts, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"Wavelength,Intensity\n{rows}")
    (tmp_path / "certificate.csv").write_text(
        "Wellenlänge (µm);µW/cm2/nm;U (%)\n0,25;3,0;1,2\n0,6;3,0;1,2\n"
    )
    return tmp_path


def test_a_lamp_makes_a_response_that_reduce_divides_out(labrun, lamp):
    made = labrun(
        "calibrate", "response", "lamp.csv", "--lamp", "certificate.csv", "--dark", "dark.csv"
    )
    table = np.loadtxt(lamp / "response.csv", delimiter=",", skiprows=3)
    shown = labrun("reduce", "lamp.csv", "--response", "response.csv", "--no-figures")
    summary = json.loads((lamp / "reduced" / "summary.json").read_text())

    assert made.returncode == 0, made.stderr
    assert "lamp.csv, less dark.csv, over certificate.csv" in made.stdout
    assert "labrun reduce SPECTRA --response response.csv" in made.stdout
    assert np.interp([350, 450], table[:, 0], table[:, 1]) == pytest.approx([0.5, 1.0], rel=1e-3)
    assert shown.returncode == 0, shown.stderr
    assert summary["notes"][0]["note"] == "the instrument's response was divided out"
    assert len(summary["configuration"]["response_sha256"]) == 64


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("lamp.csv",), "no spectrum has enough lines to tell a response; a lamp does (--lamp)"),
        (("nothing",), "no spectra in nothing"),
        (
            ("full.csv", "alike"),
            "its wavelengths are not those of",
        ),
        (("lamp.csv", "--dark", "dark.csv"), "--dark needs --lamp"),
        (("lamp.csv", "--lamp", "lost.csv"), "lost.csv: No such file"),
        (("lamp.csv", "--lamp", "empty.csv"), "empty.csv: the spectrum is empty: it has no row"),
        (("lamp.csv", "--lamp", "torn.csv"), "torn.csv: line 3 is not two numbers: 'what,3'"),
        (
            ("lamp.csv", "--lamp", "none.csv"),
            "none.csv: a certificate has two wavelengths or more, and a",
        ),
        (
            ("full.csv", "--lamp", "certificate.csv"),
            "full.csv: 1,501 channels are full; expose it for",
        ),
        (
            ("lamp.csv", "full.csv", "--lamp", "certificate.csv"),
            "full.csv: its wavelengths are not those of",
        ),
    ],
)
def test_what_cannot_be_calibrated_is_said(labrun, lamp, words, told):
    (lamp / "empty.csv").write_text("nm,radiance\n")
    (lamp / "torn.csv").write_text("nm,radiance\n250,3\nwhat,3\n300,3\n")
    (lamp / "none.csv").write_text("nm,radiance\n250,3\n300,0\n")
    rows = "".join(
        f"{at / 10},{min(at, 5000) + at % 2 * (at < 5000)}\n" for at in range(3000, 6500)
    )
    (lamp / "full.csv").write_text(f"Wavelength,Intensity\n{rows}")
    for folder in ("nothing", "alike"):
        (lamp / folder).mkdir()
    (lamp / "alike" / "lamp.csv").write_bytes((lamp / "lamp.csv").read_bytes())
    done = labrun("calibrate", "response", *words)

    assert done.returncode == 2, done.stdout
    assert told in done.stderr
    assert not (lamp / "response.csv").exists()


def test_reduce_names_a_response_that_it_cannot_use(labrun, lamp):
    done = labrun("reduce", "lamp.csv", "--response", "dark.csv")

    assert done.returncode == 2
    assert "--response dark.csv: line 1: no column wavelength_nm and response" in done.stderr
