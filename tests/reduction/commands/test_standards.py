"""`labrun calibrate standards` and `labrun reduce --calibration`, through their command line."""

import csv
import json

import numpy as np
import pytest
from folders import age
from scipy.special import voigt_profile

from labrun.drivers.simulated.twins.minerals import ELEMENTS, atom_fractions
from labrun.drivers.simulated.twins.shot import ShotMaker

PPM = {"S0": 0, "S1": 200, "S2": 500, "S3": 1000, "S4": 2000, "S5": 3000}
THREE = tuple(f"spectra/S{k}_0.csv" for k in range(3))
X = np.linspace(580.0, 690.0, 1500)


def spectrum(rng, ppm, light=1.0):
    """Counts of a shot with sodium's doublet and lithium's line."""
    bright = light * float(np.exp(0.05 * rng.standard_normal()))
    y = np.full(len(X), 200.0)
    for area, nm in ((2000, 588.995), (1000, 589.592), (0.5 * ppm, 670.78), (0.1 * ppm, 610.36)):
        y += bright * area * voigt_profile(X - nm, 0.12, 0.03)
    return y + np.sqrt(36 + 0.3 * y) * rng.standard_normal(len(X))


def write(path, *counts, x=X):
    rows = "".join(
        f"{at:.4f},{','.join(f'{c:.1f}' for c in shots)}\n"
        for at, *shots in zip(x, *counts, strict=True)
    )
    path.write_text("Wavelength," + ",".join(["Intensity"] * len(counts)) + "\n" + rows)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Three shots of each standard, one file each, and unknowns."""
    rng = np.random.default_rng(4)
    folder = tmp_path_factory.mktemp("bench")
    (folder / "spectra").mkdir()
    (folder / "unknown").mkdir()
    for sample, ppm in PPM.items():
        for n in range(2):
            write(folder / "spectra" / f"{sample}_{n}.csv", spectrum(rng, ppm))
    unknowns = {"none": 0, "some": 1500, "much": 6000}
    for name, ppm in unknowns.items():
        write(folder / "unknown" / f"{name}.csv", *(spectrum(rng, ppm) for _ in range(4)))
    write(folder / "unknown" / "bright.csv", spectrum(rng, 1500, 9.0))
    write(folder / "unknown" / "other.csv", spectrum(rng, 1500)[:1400], x=X[:1400])
    rows = "".join(f"{sample},{ppm},3\n" for sample, ppm in PPM.items())
    (folder / "standards.csv").write_text(f"sample,Li (ppm),Na2O (wt %)\n{rows}")
    age(folder)
    return folder


@pytest.fixture
def place(tmp_path, bench):
    for name in ("spectra", "unknown", "standards.csv"):
        (tmp_path / name).symlink_to(bench / name)
    return tmp_path


@pytest.mark.slow
def test_standards_make_a_calibration_by_which_unknowns_are_read(labrun, place):
    made = labrun("calibrate", "standards", "standards.csv", "spectra", "--by", "E. Curie")
    card = json.loads((place / "standards.calibration").read_text())["card"]
    done = labrun(
        "reduce", "unknown", "--calibration", "standards.calibration", "-o", "out",
        "--jobs", "1", "--no-figures"
    )  # fmt: skip
    with (place / "out" / "elements.csv").open() as file:
        lithium = {row["spectrum"]: row for row in csv.DictReader(file) if row["element"] == "Li"}
    some = lithium["some.csv"]

    assert made.returncode == 0, made.stderr
    assert "Li  670.781" in made.stdout
    assert "not calibrated: Na: all 6 standards have the same concentration" in made.stdout
    assert "note: Na2O (wt %): wt % of Na are 0.74186 times it" in made.stdout
    assert (place / "standards.png").read_bytes()[:4] == b"\x89PNG"
    assert (card["by"], card["samples"], card["spectra"], card["channels"]) == (
        "E. Curie",
        6,
        12,
        1500,
    )
    assert done.returncode == 0, done.stderr
    assert float(some["wt_percent"]) == pytest.approx(0.15, abs=2.5 * float(some["wt_percent_err"]))
    assert float(some["wt_percent_low"]) < 0.15 < float(some["wt_percent_high"])
    assert (lithium["none.csv"]["wt_percent"], lithium["none.csv"]["wt_percent_flags"]) == (
        "",
        "below LOD",
    )
    assert 0 < float(lithium["none.csv"]["wt_percent_high"]) < 0.05
    assert lithium["much.csv"]["wt_percent_flags"] == "above range: the standards end at 0.3 wt %"
    assert lithium["other.csv"]["wt_percent"] == lithium["other.csv"]["wt_percent_flags"] == ""
    assert "other.csv: no concentrations, as this is another instrument's spectrum" in done.stdout
    assert (
        "bright.csv: the total light is outside that of the calibration's standards" in done.stdout
    )


def in_one_table(place):
    """The standards and their spectra, as PyHAT has them."""
    rows = [
        "meta,comp,comp" + ",wvl" * len(X),
        ",".join(["sample,Li (ppm),Na2O", *map("{:.4f}".format, X)]),
    ]
    for path in sorted((place / "spectra").glob("*.csv")):
        counts = np.loadtxt(path, delimiter=",", skiprows=1)[:, 1]
        sample = path.name[:2]
        rows.append(",".join([sample, str(PPM[sample]), "3", *map(str, counts)]))
    (place / "table.csv").write_text("\n".join(rows) + "\n")
    return "table.csv"


def test_an_internal_standard_makes_up_for_the_light(labrun, place):
    table = in_one_table(place)
    made = labrun(
        "calibrate", "standards", table, table, "--normalise", "Na", "--line", "Li=610.36",
        "--curve", "straight", "--no-figures",
    )  # fmt: skip
    (one,) = json.loads((place / "standards.calibration").read_text())["elements"].values()

    assert made.returncode == 0, made.stderr
    assert "Li  610.361     ratio to Na  straight" in made.stdout
    assert one["internal"]["element"] == "Na"
    assert sorted(point["sample"] for point in one["points"]) == sorted(PPM)
    assert not (place / "standards.png").exists()


@pytest.mark.slow
def test_whole_spectra_tell_an_element_and_what_is_unlike_the_standards(labrun, place):
    made = labrun("calibrate", "standards", "standards.csv", "spectra", "--model", "pls")
    one = json.loads((place / "standards.calibration").read_text())["elements"]["Li"]
    odd = spectrum(np.random.default_rng(3), 1500)
    odd += 9000 * voigt_profile(X - 640.0, 0.12, 0.03)
    (place / "odd").mkdir()
    write(place / "odd" / "odd.csv", odd)
    done = labrun(
        "reduce", "unknown/some.csv", "odd", "--calibration", "standards.calibration", "-o", "out",
        "--jobs", "1", "--no-figures",
    )  # fmt: skip
    with (place / "out" / "elements.csv").open() as file:
        lithium = {row["spectrum"]: row for row in csv.DictReader(file) if row["element"] == "Li"}
    (some,) = [row for name, row in lithium.items() if name.endswith("some.csv")]

    assert made.returncode == 0, made.stderr
    assert "whole spectrum  PLS, " in made.stdout
    assert (one["line"], one["by"]) == (None, "whole spectrum")
    assert (place / "standards_spectra.png").read_bytes()[:4] == b"\x89PNG"
    assert float(some["wt_percent_low"] or 0) < 0.15 < float(some["wt_percent_high"] or 100)
    assert some["wt_percent"] or some["wt_percent_flags"] == "below LOD"
    assert "odd.csv: it is unlike the calibration's standards (Q is " in done.stdout


@pytest.mark.slow
def test_one_standard_calibrates_a_closure(labrun, tmp_path):
    maker = ShotMaker(core=1, seed=3)
    shares = atom_fractions("spodumene")
    maker.core.composition_in_crater = lambda x, y: np.array([shares.get(e, 0.0) for e in ELEMENTS])
    for n in range(2):
        shot = maker.csv({"n": n, "x": 1.2, "y": 3.0, "focus": 1.0})
        (tmp_path / f"glass_{n}.csv").write_bytes(shot)
    age(tmp_path)
    (tmp_path / "t.csv").write_text("sample,SiO2 (%),Al2O3 (%),Li2O (%)\nglass,60,30,8\n")
    made = labrun("calibrate", "standards", "t.csv", "glass_0.csv", "--closure", "oxides")
    done = labrun(
        "reduce", "glass_1.csv", "--calibration", "standards.calibration", "-o", "out", "--jobs", "1",
        "--no-figures",
    )  # fmt: skip
    with (tmp_path / "out" / "elements.csv").open() as file:
        found = {row["element"]: row for row in csv.DictReader(file) if row["wt_percent"]}
    ratio = float(found["Al"]["wt_percent"]) / float(found["Si"]["wt_percent"])

    assert made.returncode == 0, made.stderr
    assert "  Si amount times " in made.stdout
    assert "closed to 100 %" in made.stdout
    assert done.returncode == 0, done.stderr
    assert ratio == pytest.approx(30 * 0.52925 / (60 * 0.46744), rel=0.3)


@pytest.mark.parametrize(
    ("table", "words", "told"),
    [
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv",), "Li: only one standard has a concentration"),
        ("sample,Li (ppm)\nS0,5\nS1,5\n", ("spectra/S0_0.csv", "spectra/S1_0.csv"),
         "Li: all 2 standards have the same concentration (0.0005 wt %)"),
        ("sample,Li (ppm)\nS0,5\n", ("spectra/S1_0.csv",), "no row of t.csv is of this spectrum"),
        ("sample,Li (ppm),K (wt %)\nS0,5,30 ppm\n", ("spectra/S0_0.csv",), "t.csv:2: K (wt %): '30 ppm'"),
        ("sample,Li (ppm)\nS0,0\nother,9\n", ("spectra/S0_0.csv", "unknown/other.csv"),
         "1,400 channels from 580.0 to 682.6"),
        ("sample,Li (µg/g)\nS0,0\n", ("lost.csv",), "lost.csv does not exist"),
        ("PK\x03\x04", ("spectra/S0_0.csv",), "t.csv: it is a workbook; save its sheet as CSV in UTF-8"),
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv", "--line", "Li=600"), "no line of Li within 0.1 nm"),
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv", "--line", "Li"), "write it as Li=610.36"),
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv", "--normalise", "Xy"), "write none, light, or"),
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv", "--curve", "bent"), "straight or quadratic"),
        ("sample,Li (ppm)\nS0,2000\nS1,2200\nS2,2500\nS3,3000\nS4,4000\nS5,5000\n", ("spectra",),
         "Li: a sample without it would show less than nothing"),
        ("sample,Li (ppm)\nS1,200\n", ("spectra/S1_0.csv",), "one standard makes no curve; --closure"),
        ("sample,Li (ppm)\nS1,200\n", ("spectra/S1_0.csv", "--closure", "oxides"), "no one-point calib"),
        ("sample,Li (ppm)\nS1,200\n", ("spectra/S1_0.csv", "--closure", "rock"), "choose oxides or elements"),
        ("sample,Li (ppm)\nS1,200\n", ("spectra/S1_0.csv", "--closure", "oxides", "--model", "pls"),
         "--closure takes all lines"),
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv", "--model", "pca"), "write lines or pls"),
        ("sample,Li (ppm)\nS0,0\n", ("spectra/S0_0.csv", "--model", "pls", "--curve", "straight"),
         "leave out --normalise, --line, --curve"),
        ("sample,Li (ppm)\nS0,0\nS1,200\nS2,500\n", (*THREE, "--model", "pls"),
         "Li: 3 standards; a PLS model needs 6 or more"),
        ("sample,Li (ppm),Si (%)\nS0,0,20\nS1,9,30\n", ("spectra/S0_0.csv", "--normalise", "Si"),
         "Si cannot be the internal standard: the standards have 20 to 30 wt %"),
    ],
)  # fmt: skip
def test_what_cannot_be_calibrated_is_said(labrun, place, table, words, told):
    (place / "t.csv").write_text(table, encoding="cp1252")
    done = labrun("calibrate", "standards", "t.csv", *words)

    assert done.returncode == 2, done.stdout
    assert told in done.stderr
    assert not (place / "standards.calibration").exists()


@pytest.mark.parametrize(
    ("text", "told"),
    [("{", "no calibration as"), ("{}", "card: Field required"), ("[1]", "no calibration")],
)
def test_reduce_names_a_calibration_that_it_cannot_use(labrun, place, text, told):
    (place / "c.json").write_text(text)
    done = labrun("reduce", "unknown", "--calibration", "c.json")

    assert done.returncode == 2
    assert f"--calibration c.json: {told}" in done.stderr or told in done.stderr


def test_a_calibration_with_a_response_needs_that_response(labrun, place):
    (place / "response.csv").write_text("wavelength_nm,response\n500,1\n700,0.8\n")
    words = ("standards.csv", "spectra", "--response", "response.csv", "--no-figures")
    labrun("calibrate", "standards", *words)
    done = labrun("reduce", "unknown", "--calibration", "standards.calibration")

    assert done.returncode == 2
    assert "--calibration standards.calibration: it was made with a --response" in done.stderr


def test_a_calibration_without_a_response_is_told_as_that_beside_one(labrun, place):
    (place / "response.csv").write_text("wavelength_nm,response\n500,1\n700,0.8\n")
    labrun("calibrate", "standards", "standards.csv", "spectra", "--no-figures")
    words = ("--calibration", "standards.calibration", "--response", "response.csv")
    done = labrun("reduce", "unknown", *words)

    assert done.returncode == 2
    assert "it was made without a --response: leave `--response` out" in done.stderr
