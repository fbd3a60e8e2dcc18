import csv
import json
import random
import shutil

import numpy as np
import pytest
from core_tables import make_run

from labrun.reduction.mapping.choices import MapChoices
from labrun.reduction.mapping.folder import map_folder
from labrun.reduction.maps.classes.classify import classify
from labrun.reduction.maps.points.gather import gather
from labrun.reduction.maps.points.lithium import lithium_ratios

# One process makes what all of them look at.
pytestmark = pytest.mark.soak


TELLING = ("Li", "H", "K", "Na", "Si")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return make_run(tmp_path_factory.mktemp("core"))


@pytest.fixture(scope="module")
def points(run):
    return gather(run.folder)


def rows_of(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def adjusted_rand(one, other):
    """Hubert and Arabie, J. Classif. 2, 193 (1985). A shot at a boundary counts as its middle."""
    table = np.zeros((len(set(one)), len(set(other))))
    np.add.at(table, tuple(np.unique(v, return_inverse=True)[1] for v in (one, other)), 1)

    def pairs(n):
        return (n * (n - 1) / 2).sum()

    both, a, b = pairs(table), pairs(table.sum(axis=1)), pairs(table.sum(axis=0))
    chance = a * b / pairs(np.array([table.sum()]))
    return (both - chance) / ((a + b) / 2 - chance)


def test_classes_are_the_grains_of_the_core(run, points):
    classes = classify(points, TELLING)

    assert adjusted_rand(run.mineral, classes.label) >= 0.9


def test_the_likely_minerals_are_those_that_most_of_a_class_is(run, points):
    classes = classify(points, TELLING)
    named = [c for c in classes.summary if c.likely != "unnamed"]
    of_class = [run.mineral[classes.label == c.number - 1] for c in named]

    assert len(named) >= 4
    assert [np.mean(found == c.likely) > 0.7 for c, found in zip(named, of_class, strict=True)] == [
        True
    ] * len(named)


def test_lithium_and_hydrogen_tell_spodumene_and_mica_from_the_rest(run, points):
    classes = classify(points)
    spodumene = run.mineral == "spodumene"
    wet = points.area["H"] > 0

    assert classes.features == ("Li", "H")
    assert 3 <= len(classes) <= 5
    assert np.mean(classes.label[spodumene] == 0) > 0.95
    assert set(run.mineral[wet]) <= {"muscovite", "lepidolite"}
    assert len(set(classes.label[wet])) == 1


@pytest.mark.parametrize("n", [4, 5])
def test_as_many_classes_as_the_paper_saw_may_be_asked_for(run, points, n):
    classes = classify(points, n_classes=n)
    lithium = [c.area["Li"] for c in classes.summary]

    assert len(classes) == n
    assert lithium[0] == max(lithium)
    assert adjusted_rand(run.mineral, classes.label) > 0.3


def test_the_order_of_rows_changes_no_class(run, points, tmp_path):
    shutil.copytree(run.folder / "reduced", tmp_path / "reduced")
    head, *rows = (run.folder / "data.csv").read_text().splitlines()
    random.Random(4).shuffle(rows)
    (tmp_path / "data.csv").write_text("\n".join([head, *rows]))
    other = gather(tmp_path)
    labels = dict(zip(other.name, classify(other, TELLING).label.tolist(), strict=True))
    before = dict(zip(points.name, classify(points, TELLING).label.tolist(), strict=True))

    assert labels == before


def test_rows_find_their_spectra_by_the_key_at_the_end_of_the_name(points):
    assert points.spectrum.tolist() == list(range(288))
    assert "288 of 288 rows of data.csv were joined" in points.notes[0]


def test_lithium_is_a_quarter_of_spodumenes_cations_and_absorbs_itself(run, points):
    share, ratio = points.reduced.li_cation_fraction, lithium_ratios(points.reduced)
    spodumene, quartz = run.mineral == "spodumene", run.mineral == "quartz"

    assert np.nanmedian(share[spodumene]) == pytest.approx(0.25, abs=0.07)
    assert np.median(np.nan_to_num(share[quartz])) < 0.01
    assert np.nanmedian(ratio.value[spodumene]) > 0.55  # 0.47 for a thin plasma of 12,000 K


def test_everything_that_is_made_is_the_same_every_time(run, tmp_path):
    choices = MapChoices(features=TELLING, format="svg")
    made = map_folder(run.folder, tmp_path / "one", choices)
    map_folder(run.folder, tmp_path / "two", choices)
    names = {path.name for path in made.written}
    same = [
        (tmp_path / "one" / n).read_bytes() == (tmp_path / "two" / n).read_bytes() for n in names
    ]

    assert all(same)
    assert names == {
        "maps.csv", "classes.csv", "class_summary.csv", "map.json", "element_maps.svg",
        "class_map.svg", "temperature_map.svg", "classes.svg", "lithium_ratio.svg",
        "lithium_fraction.svg",
    }  # fmt: skip


def test_the_tables_say_what_was_measured_where_and_from_which_files(run, tmp_path):
    map_folder(run.folder, tmp_path, MapChoices(elements=("Li", "K"), scale="absolute"))
    rows = rows_of(tmp_path / "maps.csv")
    record = json.loads((tmp_path / "map.json").read_text())

    assert len(rows) == 2 * 288
    assert rows[1]["x_mm"] == "0.2" and rows[0]["value"] == rows[0]["area"]
    assert set(record["inputs"]) == {
        "data.csv", "reduced/peaks.csv", "reduced/elements.csv", "reduced/plasma.csv"
    }  # fmt: skip
    assert all(len(digest) == 64 for digest in record["inputs"].values())
    assert record["elements"]["Li"] == pytest.approx(670.78, abs=0.03)


def test_part_of_the_total_is_steadier_than_the_area(run, tmp_path):
    """The amount that a shot ablates varies by 6 %, and falls out of the part."""
    map_folder(run.folder, tmp_path, MapChoices(elements=("Si",), scale="total"))
    rows = rows_of(tmp_path / "maps.csv")
    quartz = run.mineral == "quartz"
    part, area = (np.array([float(r[c]) for r in rows])[quartz] for c in ("value", "area"))

    assert np.std(part) / np.mean(part) < 0.7 * np.std(area) / np.mean(area)
