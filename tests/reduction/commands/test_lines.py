"""`labrun lines`, through its command line."""

import csv
import hashlib
import json

import numpy as np
import pytest


@pytest.fixture
def told(labrun):
    return lambda *words: json.loads(labrun("lines", *words, "--json").stdout)


def test_the_lines_of_lithium_between_two_wavelengths_are_printed(labrun):
    done = labrun("lines", "Li", "--from", "600", "--to", "700", "--stage", "1")

    assert done.returncode == 0, done.stderr
    assert [line.split()[2] for line in done.stdout.splitlines()[1:]] == [
        "610.3530", "610.3640", "610.3660", "670.7758", "670.7908", "687.3074", "687.3074",
    ]  # fmt: skip
    assert "3.69e+07" in done.stdout and "AAA" in done.stdout and "1.8479" in done.stdout


def test_json_holds_the_levels_weights_and_class_of_each_line(told):
    first = told("Na", "--from", "588.9", "--to", "589.1")[0]
    strength = first.pop("strength")

    assert first == {
        "element": "Na", "stage": 1, "wavelength_nm": 588.9951, "a_ki_per_s": 61600000.0,
        "accuracy": "AA", "e_i_ev": 0.0, "e_k_ev": 2.10443, "g_i": 2, "g_k": 4,
    }  # fmt: skip
    assert strength == 100.0


def test_wavelengths_may_be_those_in_vacuum(told):
    (air,) = told("H", "--from", "656", "--to", "657")
    (vacuum,) = told("H", "--from", "656", "--to", "657", "--medium", "vacuum")

    assert vacuum["wavelength_nm"] - air["wavelength_nm"] == pytest.approx(0.181, abs=0.001)


def test_the_strongest_come_in_the_order_of_their_wavelengths(told):
    found = told("Mg", "--strongest", "3")
    wavelengths = [line["wavelength_nm"] for line in found]

    assert wavelengths == sorted(wavelengths)
    assert [round(w, 1) for w in wavelengths] == [279.6, 280.3, 285.2]


def test_ions_gain_on_atoms_in_a_hotter_plasma(told):
    def share_of_atom(kelvin):
        strength = {line["stage"]: line["strength"] for line in told(
            "Ca", "--from", "393.3", "--to", "422.7", "--strongest", "3", "-T", kelvin
        )}  # fmt: skip
        return strength[1] / strength[2]

    assert share_of_atom("8000") > 2 * share_of_atom("12000")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["Xx"], "no lines of 'Xx'; did you mean Xe"),
        (["Li", "--stage", "3"], "--stage 3: choose 1 for atoms"),
        (["Li", "--medium", "water"], "choose air or vacuum"),
        (["Li", "--from", "700", "--to", "600"], "--from 700 is greater than --to 600"),
        (["Li", "--strongest", "0"], "at least 1"),
        (["Li", "-T", "5"], "1000 to 100000 K"),
        (["Li", "--density", "nan"], "above 0"),
    ],
)
def test_wrong_usage_is_a_sentence(labrun, arguments, words):
    done = labrun("lines", *arguments)

    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_no_line_in_the_range_is_said_and_is_a_status(labrun):
    done = labrun("lines", "Li", "--from", "200", "--to", "200.1")

    assert done.returncode == 1
    assert "no matching line of Li" in done.stderr
    assert labrun("lines", "Li", "--from", "200", "--to", "200.1", "--json").stdout == "[]\n"


OSMIUM = """element,stage,wavelength_air_nm,a_ki_per_s,g_i,g_k,e_i_ev,e_k_ev
Os,1,305.866,2.9e7,9,11,0,4.0524
"""


@pytest.mark.slow
def test_lines_of_ones_own_are_listed_and_reduced(labrun, tmp_path):
    (tmp_path / "osmium.csv").write_text(OSMIUM)
    nm = np.arange(300.0, 315.0, 0.02)
    counts = (
        200 + 3000 * np.exp(-(((nm - 305.866) / 0.05) ** 2)) + 5 * np.sin(np.arange(len(nm)) ** 2)
    )
    rows = [f"{at:.3f},{count:.1f}" for at, count in zip(nm, counts, strict=True)]
    (tmp_path / "spectrum.csv").write_text("\n".join(["Wavelength,Intensity", *rows]))
    listed = labrun("lines", "Os", "--lines", "osmium.csv")
    without = labrun("reduce", "spectrum.csv", "--elements", "Os")
    done = labrun(
        "reduce",
        "spectrum.csv",
        "--elements",
        "Os",
        "--lines",
        "osmium.csv",
        "--medium",
        "air",
        "--no-figures",
    )
    told = json.loads((tmp_path / "reduced" / "summary.json").read_text())["configuration"]
    (row,) = csv.DictReader((tmp_path / "reduced" / "elements.csv").read_text().splitlines())

    assert "305.8660" in listed.stdout
    assert without.returncode == 2 and "no lines of 'Os'" in without.stderr
    assert done.returncode == 0, done.stderr
    assert row["element"] == "Os" and float(row["area"]) > 100
    assert told["lines_sha256"] == hashlib.sha256(OSMIUM.encode()).hexdigest()


def test_a_file_of_lines_that_cannot_be_used_is_named_with_the_reason(labrun, tmp_path):
    (tmp_path / "bad.csv").write_text(OSMIUM.replace("Os,1", "Os,7"))
    for command in (("lines", "Os"), ("reduce", "."), ("spectrum", "bad.csv")):
        done = labrun(*command, "--lines", "bad.csv")

        assert done.returncode == 2
        assert "bad.csv: row 2: stage is 1 (I, atoms) or 2 (II, ions), not '7'" in done.stderr
    missing = labrun("lines", "Os", "--lines", "nowhere.csv")

    assert missing.returncode == 2 and "--lines nowhere.csv: No such file" in missing.stderr
