"""Classes by wt %, and the minerals that they may be."""

import csv

import numpy as np
import pytest

from labrun.reduction.mapping.choices import MapChoices
from labrun.reduction.mapping.folder import map_folder
from labrun.reduction.maps.classes.composition import IDEAL, likely

CATIONS = ("Li", "Na", "K", "Be", "Mg", "Ca", "Al", "Si", "Fe", "P", "B", "Zr", "Sn", "Cu")
MADE = ["spodumene", "K-feldspar", "quartz"]


def measured(name, elements, factor=1.0, error=0.08):
    mean = {e: factor * IDEAL[name].get(e, 0.0) for e in elements}
    return mean, {e: error * c + 0.05 for e, c in mean.items()}


def test_each_mineral_is_named_by_its_own_composition():
    told = {name: likely(*measured(name, CATIONS))[0] for name in IDEAL}
    wrong = {name: said for name, said in told.items() if said not in (name, "unnamed")}
    alike = {name for name, said in told.items() if said == "unnamed"}

    assert wrong == {}
    # Carbon, fluorine and sulphur were not measured, and two oxides of iron are alike.
    assert alike <= {
        "calcite",
        "magnesite",
        "siderite",
        "fluorite",
        "pyrite",
        "hematite",
        "magnetite",
    }


@pytest.mark.parametrize(
    ("mean", "error"),
    [
        measured("spodumene", ("Li", "Al", "Si"), 0.4),  # of no mineral
        measured("spodumene", ("Li",)),  # one element of three tells nothing
        measured("spodumene", ("Li", "Al", "Si"), 1.0, 0.9),  # errors that hold many
    ],
)
def test_what_is_like_none_or_many_gets_no_name(mean, error):
    assert likely(mean, error) == ("unnamed", "")


def test_a_map_in_wt_percent_has_classes_of_both_kinds(tmp_path):
    rng, elements = np.random.default_rng(2), ("Li", "K", "Al", "Si")
    head = ["key", "x", "y", *elements]
    head += [
        f"{e}_{end}"
        for e in elements
        for end in ("wt_percent", "wt_percent_err", "wt_percent_high")
    ]
    rows = []
    for k in range(36):
        true = IDEAL[MADE[k // 12]]
        areas = [f"{100 * true.get(e, 0.0):.1f}" for e in elements]
        wt = []
        for e in elements:
            c = true.get(e, 0.0)
            known = [f"{c * (1 + 0.05 * rng.normal()):.4f}", f"{0.08 * c:.4f}", ""]
            wt += known if c else ["", "", "0.05"]
        rows.append([str(k), str(k % 6), str(k // 6), *areas, *wt])
    (tmp_path / "data.csv").write_text("\n".join(",".join(row) for row in [head, *rows]))
    result = map_folder(tmp_path, tmp_path / "maps", MapChoices())
    summary = (tmp_path / "maps" / "class_summary_by_wt_percent.csv").read_text().splitlines()
    told = {row["likely"]: row for row in csv.DictReader(summary)}

    assert told.keys() == set(MADE)
    assert all(row["points"] == "12" for row in told.values())
    assert float(told["spodumene"]["Li"]) == pytest.approx(IDEAL["spodumene"]["Li"], rel=0.1)
    assert "(3.73)" in told["spodumene"]["why"]
    assert {"classes.csv", "classes_by_wt_percent.csv", "class_map_by_wt_percent.png"} <= {
        path.name for path in result.written
    }
    assert any(note.startswith("3 classes by wt % of ") for note in result.notes)
