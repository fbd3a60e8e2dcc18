"""What gantry@2 adds: ranges of the lab or machine, touch, outputs, overrides, safe height, more axes."""

import asyncio

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.grbl.dialect import override_bytes
from labrun.drivers.grbl.gantry import Grbl
from labrun.drivers.simulated.gantry import SimGantry
from labrun.schemas.contracts import shipped_contracts

TWO = shipped_contracts()["gantry@2"]


@pytest.fixture
def gantry(tmp_path):
    def make(peer, limits=None, **config):
        config = {"port": peer.path, **config}
        return Grbl(Place("gantry", config, limits or {}, tmp_path / "gantry", tmp_path, TWO))

    return make


def test_the_range_is_the_machines_own_where_the_lab_gives_none(peers, gantry, played):
    peer = peers(settings={130: 1000.0})

    async def story(driver):
        with pytest.raises(ActionFailed, match="x 996 mm is outside 0 to 995 mm"):
            await driver.move_to(GoalContext("a"), x=996)
        return await driver.move_to(GoalContext("b"), x=994)

    assert played(gantry(peer), story)["x"] == pytest.approx(994, abs=0.005)


def test_a_range_may_be_negative(peer, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed, match="x -401 mm is outside -400 to 50 mm"):
            await driver.move_to(GoalContext("a"), x=-401)
        return await driver.move_to(GoalContext("b"), x=-300.5)

    driver = gantry(peer, {"x": (-400, 50)}, origin={"x": -400})

    assert played(driver, story)["x"] == pytest.approx(-300.5, abs=0.005)


def test_touch_finds_the_surface_and_says_where_it_touched(peer, gantry, played):
    peer.surface = -60.0

    async def story(driver):
        found = await driver.touch(GoalContext("a"), to=5.0, feed=600)
        with pytest.raises(ActionFailed, match="touches already"):
            await driver.touch(GoalContext("b"), to=5.0)
        pins = (await driver.status())["pins"]
        await driver.move_to(GoalContext("c"), z=60)
        return found, pins

    found, pins = played(gantry(peer), story)

    assert found["z"] == pytest.approx(30, abs=0.01)
    assert pins == "P"
    assert peer.place[2] == pytest.approx(-30, abs=0.01)


def test_touch_that_ended_on_its_way_has_not_touched_nothing(peer, gantry, played):
    peer.probes_half = True

    async def story(driver):
        with pytest.raises(ActionFailed, match="touched nothing, and it stands at z 67") as missed:
            await driver.touch(GoalContext("a"), to=50.0, feed=2000)
        return missed.value

    assert (played(gantry(peer), story).name, peer.place[2]) == (
        "WrongPlace",
        pytest.approx(-22.5, abs=0.01),
    )


def test_touch_that_meets_nothing_says_so_and_the_place_is_still_trusted(peer, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed) as missed:
            await driver.touch(GoalContext("a"), to=50.0, feed=2000)
        await driver.move_to(GoalContext("b"), z=60)
        return missed.value

    missed = played(gantry(peer), story)

    assert (missed.name, missed.happened) == ("NoContact", "yes")


def test_outputs_are_switched_and_the_safe_state_switches_them_off(peer, gantry, played):
    async def story(driver):
        await driver.set_output(GoalContext("a"), output="laser", on=True, power=25)
        await driver.set_output(GoalContext("b"), output="argon", on=True)
        on = set(peer.outputs), (await driver.status())["outputs"]
        await driver.safe()
        for output, why in (("pump", r"no output pump; it has laser, argon"), ("mist", "error:20")):
            with pytest.raises(ActionFailed, match=why):
                await driver.set_output(GoalContext("c"), output=output, on=True)
        return on, set(peer.outputs), (await driver.status())["outputs"]

    driver = gantry(peer, outputs={"laser": "spindle", "argon": "flood", "mist": "mist"})

    on, off, told = played(driver, story)

    assert on == ({3, 8}, ["argon", "laser"])
    assert (off, told) == (set(), [])
    assert "M3S250.000" in peer.heard


def test_in_laser_mode_an_output_that_would_stay_dark_is_told(peers, gantry, played):
    peer = peers(settings={32: 1})

    async def story(driver):
        with pytest.raises(
            ActionFailed, match=r"^NotAvailable: .*\$32=1.*laser: \{on: M3 S1000, off: M5"
        ):
            await driver.set_output(GoalContext("a"), output="laser", on=True)
        await driver.set_output(GoalContext("b"), output="laser", on=False)
        await driver.set_output(GoalContext("c"), output="cutter", on=True)

    lines = {"on": "M3 S1000", "off": "M5"}
    played(gantry(peer, outputs={"laser": "spindle", "cutter": lines}), story)

    assert "M5" in peer.heard and peer.heard[-1] != "M3S1000.000"


@pytest.mark.parametrize("fluid", [False, True])
def test_an_override_is_seen_in_the_reports(peers, gantry, played, fluid):
    peer = peers(fluid=fluid)

    async def story(driver):
        await driver.override(GoalContext("a"), feed=137, rapid=25)
        status = await driver.status()
        return status["feed_override"], status["rapid_override"], status["machine_x"]

    stands = 0 if fluid else -805
    assert played(gantry(peer), story) == (137, 25, pytest.approx(stands, abs=0.006))


def test_an_override_of_which_steps_were_lost_is_made_again_and_slower(peer, gantry, played):
    async def story(driver):
        peer.loop_s = 0.08
        await driver.override(GoalContext("a"), feed=137)
        return (await driver.status())["feed_override"]

    assert played(gantry(peer), story) == 137


@pytest.mark.parametrize(("feed", "data"), [(100, b"\x90"), (85, b"\x90\x92\x94\x94\x94\x94\x94")])
def test_an_override_is_made_of_steps(feed, data):
    assert override_bytes(feed, None) == data


def test_a_safe_height_lifts_goes_across_and_lowers(peer, gantry, played):
    peer.speed = 20

    async def story(driver):
        await driver.move_to(GoalContext("a"), x=1, y=1, z=5)
        since = len(peer.heard)
        place = await driver.move_to(GoalContext("b"), x=50, y=60, z=2, safe_z=40)
        return place, [line for line in peer.heard[since:] if "G53" in line]

    place, lines = played(gantry(peer), story)

    assert (place["x"], place["z"]) == pytest.approx((50, 2), abs=0.005)
    assert [line.partition("G0")[2] for line in lines] == [
        "Z-50.0000",
        "X-755.0000Y-665.0000",
        "Z-88.0000",
    ]


def test_an_axis_that_the_machine_lacks_is_refused(peer, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed, match="no axis a; it has x, y, z") as refused:
            await driver.move_to(GoalContext("a"), a=10)
        return refused.value.name

    assert played(gantry(peer), story) == "NotAvailable"


def test_the_alarm_has_its_number(peer, gantry, played):
    peer.hit_at = -700

    async def story(driver):
        with pytest.raises(ActionFailed, match="ALARM:1"):
            await driver.move_to(GoalContext("a"), x=200)
        return await driver.status()

    assert played(gantry(peer), story)["alarm_code"] == 1


def test_under_gantry_1_the_range_stays_that_contracts_own(peers, tmp_path, played):
    peer = peers(settings={130: 1000.0})
    one = shipped_contracts()["gantry@1"]
    driver = Grbl(Place("g", {"port": peer.path}, {"x": (0, 1000)}, tmp_path, tmp_path, one))

    async def story(driver):
        with pytest.raises(ActionFailed, match="x 731 mm is outside 0 to 730 mm"):
            await driver.move_to(GoalContext("a"), x=731)

    played(driver, story)


def test_the_simulated_gantry_speaks_it_too(tmp_path):
    place = Place("g", {"clock": "fast", "homed": True}, {"x": (-50, 900)}, tmp_path, tmp_path, TWO)
    driver = SimGantry(place)

    async def story():
        await driver.open()
        try:
            await driver.move_to(GoalContext("a"), x=-20, z=30)
            far = await driver.move_to(GoalContext("b"), x=850, safe_z=60)
            return far, await driver.touch(GoalContext("c"), to=1)
        finally:
            await driver.close()

    far, found = asyncio.run(story())

    assert (far["x"], far["z"]) == pytest.approx((850, 30), abs=0.005)
    assert found["z"] == pytest.approx(10, abs=0.01)
