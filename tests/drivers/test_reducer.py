"""The reducer turns a spectrum that came along with its goal into areas of elements."""

import asyncio
import hashlib
import threading
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.reducer import Reducer, most_at_once
from labrun.drivers.simulated.twins.minerals import ELEMENTS, atom_fractions
from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.schemas.messages import FileContent

from .played import played as driver_played

CALIBRATION = files("labrun.protocols").joinpath("simulated.calibration").read_text()


def played(folder: Path, story):
    return driver_played(Reducer(Place("reduce", {}, {}, folder, folder)), story)


def goal_with(data: bytes) -> GoalContext:
    content = FileContent(path="s.csv", sha256=hashlib.sha256(data).hexdigest(), data=data)
    return GoalContext("g", files={"spectrum": content})


@pytest.fixture(scope="module")
def spodumene() -> bytes:
    maker = ShotMaker(core=3, seed=1)
    shares = atom_fractions("spodumene")
    atoms = np.array([shares.get(element, 0.0) for element in ELEMENTS])
    maker.core.composition_in_crater = lambda x, y: atoms
    return maker.csv({"n": 1, "x": 1.0, "y": 1.0, "focus": 1.0})


def made_up() -> bytes:
    """A spectrum of noise and a few lines."""
    wavelength = np.linspace(190.0, 950.0, 22_800)
    counts = 200 + np.random.default_rng(1).normal(0, 5, 22_800)
    for centre in np.arange(200.0, 940.0, 20):
        counts += 4000 / (1 + ((wavelength - centre) / 0.05) ** 2)
    rows = (f"{x:.5f},{y:.1f}" for x, y in zip(wavelength, counts, strict=True))
    return "\n".join(("wavelength,intensity", *rows)).encode()


@pytest.mark.slow
class TestReducer(KeepsContract):
    case = Case(
        driver=f"{Path(__file__).with_name('patient_reducer.py')}:PatientReducer",
        slow={"pause": 2.5},
        good={"reduce": {"spectrum": "s.csv", "elements": ["Li", "K"]}},
        files={"spectrum": made_up(), "calibration": b"{}", "response": b""},
        bad={"reduce": [{"spectrum": "s.csv", "elements": ["lithium"]}]},
        lasting="reduce",
    )


def test_a_spectrum_of_spodumene_is_full_of_lithium_and_has_no_potassium(tmp_path, spodumene):
    async def story(driver):
        return await driver.reduce(
            goal_with(spodumene), spectrum="s.csv", elements=["Li", "Si", "Al", "K"]
        )

    result = played(tmp_path, story)

    assert set(result["areas"]) == {"Li", "Si", "Al", "K"}
    assert result["areas"]["Li"] > 500
    assert result["areas"]["K"] < 5
    assert result["n_peaks"] > 30


def test_a_spectrum_may_be_a_file_that_it_can_see(tmp_path, spodumene):
    (tmp_path / "s.csv").write_bytes(spodumene)

    async def story(driver):
        return await driver.reduce(GoalContext("g"), spectrum=str(tmp_path / "s.csv"))

    assert played(tmp_path, story)["areas"]["Li"] > 500


def test_several_spectra_are_reduced_at_a_time(tmp_path, spodumene):
    async def story(driver):
        goals = [driver.reduce(goal_with(spodumene), spectrum="s.csv") for _ in range(3)]
        return await asyncio.gather(*goals)

    first, *others = played(tmp_path, story)

    assert all(other == first for other in others)


def test_a_heap_of_spectra_waits_its_turn_while_the_loop_goes_on(tmp_path, spodumene):
    async def story(driver):
        goals = [
            asyncio.create_task(driver.reduce(goal_with(spodumene), spectrum="s.csv"))
            for _ in range(12)
        ]
        turns = most = 0
        while not all(goal.done() for goal in goals):
            await asyncio.sleep(0.001)
            turns += 1
            threads = [t for t in threading.enumerate() if t.name.startswith("reduce")]
            most = max(most, len(threads))
        return turns, most, [goal.result()["n_peaks"] for goal in goals]

    turns, most, peaks = played(tmp_path, story)

    assert turns > 12
    assert 1 <= most <= most_at_once()
    assert len(set(peaks)) == 1


def calibrated(folder: Path, spectrum: bytes, text: str, response: str | None = None) -> dict:
    async def story(driver):
        goal = goal_with(spectrum)
        goal.files["calibration"] = FileContent(path="c", sha256="", data=text.encode())
        if response is not None:
            goal.files["response"] = FileContent(path="r", sha256="", data=response.encode())
        return await driver.reduce(
            goal, spectrum="s.csv", elements=["Li", "K", "Rb"], calibration="c.calibration",
            response=None if response is None else "r.csv",
        )  # fmt: skip

    return played(folder, story)


def test_with_a_calibration_a_spectrum_has_concentrations(tmp_path, spodumene):
    result = calibrated(tmp_path, spodumene, CALIBRATION)
    li = {name: result[name]["Li"] for name in result if name.startswith("wt_percent")}

    assert li["wt_percent"] == pytest.approx(3.7, rel=0.25)
    assert li["wt_percent_low"] < li["wt_percent"] < li["wt_percent_high"]
    assert result["wt_percent"]["K"] is None and result["wt_percent_high"]["K"] < 0.5
    assert result["wt_percent_flags"]["K"] == "below LOD"
    assert result["wt_percent_flags"]["Rb"] == "not calibrated"
    assert list(result["areas"]) == ["Li", "K", "Rb"]
    assert result["calibration_sha256"] == hashlib.sha256(CALIBRATION.encode()).hexdigest()
    assert result["doubts"] == ""


def test_a_closure_tells_wt_percent_without_standards(tmp_path, spodumene):
    async def story(driver):
        goal = goal_with(spodumene)
        told = await driver.reduce(goal, spectrum="s.csv", elements=["Si", "K"], closure="oxides")
        with pytest.raises(ActionFailed, match="WrongCalibration: closure is without standards"):
            await driver.reduce(
                goal,
                spectrum="s.csv",
                elements=["Si"],
                closure="oxides",
                calibration="c.calibration",
            )
        return told

    result = played(tmp_path, story)

    assert (
        result["wt_percent_low"]["Si"]
        < result["wt_percent"]["Si"]
        < result["wt_percent_high"]["Si"]
    )
    assert set(result["areas"]) == {"Si", "K"}
    assert "calibration_sha256" not in result


RESPONSE = "wavelength_nm,response\n190,1\n600,1\n600.1,0.5\n961,0.5\n"


def test_a_response_is_divided_out(tmp_path, spodumene):
    (tmp_path / "r.csv").write_text(RESPONSE)

    async def story(driver):
        given = {"spectrum": "s.csv", "elements": ["Li", "Si"]}
        as_it_is = await driver.reduce(goal_with(spodumene), **given)
        divided = {**given, "response": str(tmp_path / "r.csv")}
        return as_it_is["areas"], await driver.reduce(goal_with(spodumene), **divided)

    before, after = played(tmp_path, story)

    assert after["areas"]["Li"] / before["Li"] == pytest.approx(2, rel=0.02)  # at 671 nm
    assert after["areas"]["Si"] / before["Si"] == pytest.approx(1, rel=0.02)  # at 288 nm
    assert after["response_sha256"] == hashlib.sha256(RESPONSE.encode()).hexdigest()


def test_a_calibration_is_used_with_the_response_that_it_was_made_with(tmp_path, spodumene):
    own = hashlib.sha256(RESPONSE.encode()).hexdigest()
    made = CALIBRATION.replace('"response_sha256": null', f'"response_sha256": "{own}"')

    told = calibrated(tmp_path, spodumene, made, RESPONSE)

    assert told["wt_percent"]["Li"] > 3.7  # the calibration was made without: its light is doubled
    assert (told["response_sha256"], len(told["calibration_sha256"])) == (own, 64)
    with pytest.raises(ActionFailed, match="made without a response: leave `response` out"):
        calibrated(tmp_path, spodumene, CALIBRATION, RESPONSE)
    with pytest.raises(ActionFailed, match="made with another response: give that file"):
        calibrated(tmp_path, spodumene, made, RESPONSE + "\n")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "it is empty"),
        ("nm,counts\n1,2\n", "line 1: no column wavelength_nm and response"),
        ("wavelength_nm,response\n200,-1\n300,1\n", "line 2: wavelength and response must be numbers"),
    ],
)  # fmt: skip
def test_a_response_that_cannot_be_used_is_refused(tmp_path, spodumene, text, why):
    with pytest.raises(ActionFailed, match=f"WrongResponse: r.csv: {why}"):
        calibrated(tmp_path, spodumene, CALIBRATION, text)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{}", "no calibration as `labrun calibrate standards` writes it"),
        (CALIBRATION.replace('"channels": 22800', '"channels": 2048'), "another instrument: 22,800 channels"),
        (CALIBRATION.replace('"response_sha256": null', '"response_sha256": "a"'), "with a response: give"),
    ],
)  # fmt: skip
def test_a_calibration_that_does_not_fit_is_refused(tmp_path, spodumene, text, why):
    with pytest.raises(ActionFailed, match=f"WrongCalibration: c.calibration: .*{why}"):
        calibrated(tmp_path, spodumene, text)


@pytest.mark.parametrize("data", [b"", b"wavelength,intensity\n", b"\x00\xff\xfe", b"1\n2\n3\n"])
def test_what_is_no_spectrum_is_unreadable(tmp_path, data):
    async def story(driver):
        with pytest.raises(ActionFailed, match=r"Unreadable: s\.csv: "):
            await driver.reduce(goal_with(data), spectrum="s.csv")

    played(tmp_path, story)


def test_a_file_that_is_not_there_is_unreadable(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match="Unreadable"):
            await driver.reduce(GoalContext("g"), spectrum=str(tmp_path / "none.csv"))

    played(tmp_path, story)
