"""The simulated analyser fires once a goal, knows its shots after a kill, and exports spectra."""

import asyncio
import hashlib
from pathlib import Path

import numpy as np
import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.libs import SimLibs
from labrun.drivers.simulated.twins.core import Core
from labrun.drivers.world import World
from labrun.reduction import read_spectrum

from ..played import played


def libs(folder: Path, **config) -> SimLibs:
    return SimLibs(Place("libs", {"clock": "fast", **config}, {}, folder / "libs", folder))


def place_of(mineral: str) -> tuple[float, float]:
    """A place of the demonstration window in the middle of a grain of it."""
    core = Core()
    for x in np.arange(0.3, 3.8, 0.1):
        for y in np.arange(0.3, 9.8, 0.1):
            around = core.kind.ravel()[core.grain_at(x + NEAR[0], y + NEAR[1])]
            if len(set(around)) == 1 and core.mineral_at(x, y) == mineral:
                return float(x), float(y)
    raise AssertionError(f"no {mineral} in the window")


NEAR = 0.15 * np.array([[0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])


async def shot_at(driver: SimLibs, goal: str, x: float, y: float, z: float = 0.0) -> np.ndarray:
    """The two columns of the spectrum of a shot at a place."""
    driver.world.publish("gantry", {"x": x, "y": y, "z": z})
    shot = (await driver.measure(GoalContext(goal)))["shot_id"]
    return await exported(driver, shot)


async def exported(driver: SimLibs, shot: str) -> np.ndarray:
    goal = GoalContext("export")
    await driver.export(goal, shot=shot, file="s.csv")
    spectrum = read_spectrum(goal.files["file"].data)
    return np.array([spectrum.wavelength_nm, spectrum.intensity])


def net(spectrum: np.ndarray, line_nm: float) -> float:
    """Counts of a line's peak over what is beside it."""
    wavelength, counts = spectrum
    beside = (abs(wavelength - line_nm) > 0.8) & (abs(wavelength - line_nm) < 1.4)
    return float(counts[abs(wavelength - line_nm) < 0.08].max() - np.median(counts[beside]))


class TestSimLibs(KeepsContract):
    case = Case(
        driver="sim_libs",
        config={"clock": "fast"},
        slow={"clock": 3},
        good={
            "measure": {}, "last_shot": {}, "export": {"shot": "shot-000001", "file": "s/a.csv"},
            "disarm": {}, "locate": {}, "reconnect": {},
        },
        needs={"export": ["measure"]},
        lasting="measure",
    )  # fmt: skip

    def is_safe(self, status):
        return status["armed"] is False


def test_minerals_show_the_lines_of_what_they_are_made_of(tmp_path):
    async def story(driver):
        minerals = ("spodumene", "K-feldspar", "quartz", "albite")
        return {name: await shot_at(driver, name, *place_of(name)) for name in minerals}

    spectra = played(libs(tmp_path), story)

    assert net(spectra["spodumene"], 670.78) > 5000
    assert net(spectra["spodumene"], 610.36) > 1000
    assert net(spectra["K-feldspar"], 766.49) > 1500
    assert net(spectra["K-feldspar"], 769.90) > 800
    assert net(spectra["quartz"], 670.78) < 60
    assert net(spectra["quartz"], 288.16) > 10_000
    assert net(spectra["albite"], 588.99) > 5000


def test_an_export_is_a_csv_of_22800_channels(tmp_path):
    async def story(driver):
        shot = (await driver.measure(GoalContext("m")))["shot_id"]
        goal = GoalContext("e")
        result = await driver.export(goal, shot=shot, file="spectra/a.csv")
        return result, goal.files["file"]

    result, file = played(libs(tmp_path), story)
    lines = file.data.decode("ascii").splitlines()

    assert result == {"file": "spectra/a.csv", "sha256": hashlib.sha256(file.data).hexdigest()}
    assert (file.path, file.sha256) == (result["file"], result["sha256"])
    assert lines[0] == "wavelength,intensity"
    assert len(lines) == 22_801
    assert (lines[1].split(",")[0], lines[-1].split(",")[0]) == ("190.0000", "950.0000")
    assert all(float(line.split(",")[1]) >= 0 for line in lines[1:])


def test_the_same_shot_has_the_same_spectrum_and_the_next_another(tmp_path):
    async def story(driver):
        first = await shot_at(driver, "a", 1.0, 1.0)
        second = await shot_at(driver, "b", 1.0, 1.0)
        return first, second, await exported(driver, "shot-000001")

    first, second, again = played(libs(tmp_path / "one"), story)
    elsewhere, _, _ = played(libs(tmp_path / "two"), story)
    other_seed, _, _ = played(libs(tmp_path / "three", seed=2), story)

    assert np.array_equal(first, again)
    assert np.array_equal(first, elsewhere)
    assert not np.array_equal(first, second)
    assert not np.array_equal(first, other_seed)


def test_light_is_lost_out_of_focus(tmp_path):
    x, y = place_of("spodumene")

    async def story(driver):
        return [net(await shot_at(driver, f"{z}", x, y, z), 670.78) for z in (0.0, 1.0, 2.0)]

    sharp, blurred, faint = played(libs(tmp_path), story)

    assert 0.5 * sharp < blurred < 0.8 * sharp
    assert faint < 0.3 * sharp


def test_a_shot_far_from_the_surface_or_beside_the_core_has_no_signal_but_happened(tmp_path):
    async def story(driver):
        for x, z, why in ((1.0, 10.0, "out of focus"), (60.0, 0.0, "no sample")):
            driver.world.publish("gantry", {"x": x, "y": 1.0, "z": z})
            with pytest.raises(ActionFailed, match=why) as failed:
                await driver.measure(GoalContext(why))
            assert failed.value.name == "NoSignal"
        last = await driver.last_shot(GoalContext("probe"))
        return last, (await exported(driver, last["shot_id"]))[1].max()

    last, brightest = played(libs(tmp_path), story)

    assert last == {"shot_id": "shot-000002", "goal_id": "no sample"}
    assert brightest < 100


def test_what_it_really_did_stands_in_the_world(tmp_path):
    async def story(driver):
        driver.world.publish("gantry", {"x": 1.5, "y": 2.5, "z": 0.25})
        await driver.measure(GoalContext("run/main/scan/0,0/shoot/1"))

    played(libs(tmp_path), story)
    (shot,) = World(tmp_path).truth("libs").entries()

    assert shot["what"] == "shot"
    assert shot["goal"] == "run/main/scan/0,0/shoot/1"
    assert (shot["x"], shot["y"], shot["z"]) == (1.5, 2.5, 0.25)
    assert 0.9 < shot["focus"] < 1


def test_a_shot_that_nobody_fired_cannot_be_exported(tmp_path):
    async def story(driver):
        await driver.measure(GoalContext("m"))
        for shot in ("shot-000002", "shot-1", "1", "", "shot-²"):
            with pytest.raises(ActionFailed, match="UnknownShot"):
                await driver.export(GoalContext("e"), shot=shot, file="a.csv")

    played(libs(tmp_path), story)


@pytest.mark.parametrize(("error", "shots"), [("ButtonNotFound", 0), ("NoSignal", 1)])
def test_an_ordered_fault_keeps_its_word_on_whether_it_happened(tmp_path, error, shots):
    async def story(driver):
        with pytest.raises(ActionFailed, match=error):
            await driver.measure(GoalContext("m"))

    played(libs(tmp_path, faults={"measure": {error: 1.0}}), story)

    assert len(list(World(tmp_path).truth("libs").entries())) == shots


def test_a_fault_whose_outcome_is_unknown_happened_now_and_then(tmp_path):
    async def story(driver):
        for n in range(40):
            with pytest.raises(ActionFailed, match="DialogOpen"):
                await driver.measure(GoalContext(f"goal {n}"))
        return len(driver.truth)

    assert 8 < played(libs(tmp_path, faults={"measure": {"DialogOpen": 1.0}}), story) < 32


@pytest.mark.parametrize("clock", ["real", "fast"])
def test_the_safe_state_keeps_a_waiting_shot_from_being_fired(tmp_path, clock):
    async def story(driver):
        shot = asyncio.create_task(driver.measure(GoalContext("m")))
        await asyncio.sleep(0)
        await driver.safe()
        with pytest.raises(ActionFailed, match="locked before it fired") as refused:
            await shot
        return refused.value.happened, await driver.status()

    happened, status = played(libs(tmp_path, clock=clock), story)

    assert happened == "no"
    assert (status["armed"], status["shots"]) == (False, 0)


def test_an_analyser_that_is_opened_again_goes_on_counting_and_has_its_old_spectra(tmp_path):
    async def fire(driver):
        await driver.measure(GoalContext("first"))

    async def story(driver):
        after = await driver.measure(GoalContext("next"))
        return after, await exported(driver, "shot-000001")

    played(libs(tmp_path), fire)
    after, spectrum = played(libs(tmp_path), story)

    assert after == {"shot_id": "shot-000002"}
    assert spectrum.shape == (2, 22_800)


def test_an_analyser_that_never_fired_has_no_last_shot(tmp_path):
    async def story(driver):
        return await driver.last_shot(GoalContext("probe"))

    assert played(libs(tmp_path), story) == {"shot_id": None, "goal_id": ""}
