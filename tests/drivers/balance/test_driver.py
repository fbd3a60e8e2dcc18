"""The balance on a serial line, against an emulator on a pseudo-terminal."""

import asyncio
import termios
from contextlib import contextmanager
from pathlib import Path

import pytest

from labrun.drivers.balance.driver import Balance
from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place

from ..played import played
from .balance_emulator import BalanceEmulator

pytestmark = pytest.mark.posix("Windows has no pseudo-terminals")


class TestBalance(KeepsContract):
    case = Case(
        driver="balance",
        good={"zero": {}, "tare": {}, "weigh": {"patience": 2.5}},
        bad={"weigh": [{"patience": "10 s"}]},
        lasting="weigh",
    )

    @contextmanager
    def peer(self, folder, *, slow):
        with BalanceEmulator(folder / "balance", stable=not slow, load_g=2.0) as emulator:
            yield {"port": str(emulator.link)}


@pytest.fixture
def emulator(tmp_path):
    with BalanceEmulator(tmp_path / "balance") as emulator:
        yield emulator


def balance(emulator: BalanceEmulator, **config) -> Balance:
    config = {"port": str(emulator.link), **config}
    return Balance(Place("balance", config, {}, Path(), Path()))


def weigh(driver, **params):
    return driver.weigh(GoalContext("w"), **params)


def test_it_weighs_above_the_tare_and_says_what_it_is(emulator):
    async def story(driver):
        tare = await driver.tare(GoalContext("t"))
        emulator.load_g += 0.2501
        return tare, await weigh(driver), await driver.status(), driver.versions

    tare, reading, status, versions = played(balance(emulator), story)

    assert tare == {"tare": 12.5}
    assert reading == {"mass": 0.2501, "stable": True}
    assert status == {"mass": 0.2501, "stable": True, "tared": True}
    assert versions == {
        "model": "XS204 Excellence 220.0090 g",
        "software": "2.10 10.28.0.493.142",
        "serial_number": "B123456789",
    }


def test_a_reading_that_never_stands_still_is_told_as_it_is_when_the_patience_ends(emulator):
    emulator.stable = False

    assert played(balance(emulator), lambda d: weigh(d, patience=0.5)) == {
        "mass": 12.5,
        "stable": False,
    }


def test_zero_forgets_the_tare_and_wants_an_empty_pan(emulator):
    async def story(driver):
        with pytest.raises(
            ActionFailed, match="NotEmpty: the load on the pan is too heavy to zero"
        ):
            await driver.zero(GoalContext("z"))
        await driver.tare(GoalContext("t"))
        emulator.load_g = 0.5
        await driver.zero(GoalContext("z"))
        return await driver.status()

    status = played(balance(emulator), story)

    assert status == {"mass": 0.0, "stable": True, "tared": False}


@pytest.mark.parametrize(("load_g", "words"), [(230.0, "too heavy"), (-20.0, "is the pan on")])
def test_what_is_beyond_its_range_is_an_overload(emulator, load_g, words):
    emulator.load_g = load_g

    for ask in (weigh, lambda d: d.tare(GoalContext("t"))):
        with pytest.raises(ActionFailed, match=f"Overload: .*{words}"):
            played(balance(emulator), ask)


def test_a_load_that_it_cannot_weigh_cannot_be_zeroed_either(emulator):
    emulator.load_g = 230.0

    with pytest.raises(ActionFailed, match="NotEmpty"):
        played(balance(emulator), lambda driver: driver.zero(GoalContext("z")))


def test_a_balance_that_is_busy_is_waited_for(emulator):
    emulator.busy = True

    async def story(driver):
        with pytest.raises(ActionFailed, match="Busy: the balance is busy: it answers I"):
            await weigh(driver, patience=0.5)
        waiting = asyncio.create_task(weigh(driver))
        await asyncio.sleep(0.5)
        emulator.busy = False
        return await waiting

    assert played(balance(emulator), story)["mass"] == 12.5


def test_tare_and_zero_are_not_sent_before_the_reading_stands_still(emulator, monkeypatch):
    monkeypatch.setattr("labrun.drivers.balance.driver.PATIENCE_S", 0.5)
    emulator.stable = False

    async def story(driver):
        for action in (driver.tare, driver.zero):
            with pytest.raises(ActionFailed, match=r"Unstable: no stable reading within 0\.5 s"):
                await action(GoalContext("g"))

    played(balance(emulator), story)

    assert not {"T", "Z", "@"} & set(emulator.heard)


def test_a_stream_that_somebody_left_running_is_ended(emulator):
    emulator._repeats = True

    reading = played(balance(emulator), weigh)

    assert reading["stable"]
    assert not emulator._repeats


def test_one_burst_of_noise_is_asked_through(emulator):
    async def story(driver):
        emulator.noise = b"\xff\x00S S 99"
        return await weigh(driver)

    assert played(balance(emulator), story) == {"mass": 12.5, "stable": True}


def test_kilograms_are_told_in_grams_and_newtons_are_refused(emulator):
    async def story(driver):
        emulator.unit = "kg"
        kilograms = await weigh(driver)
        emulator.unit = "N"
        with pytest.raises(ActionFailed, match="weighs in 'N'; set its unit to g"):
            await weigh(driver)
        return kilograms["mass"]

    assert played(balance(emulator), story) == 12_500


def test_a_balance_of_level_0_says_that_it_cannot_tare(emulator):
    async def story(driver):
        emulator.level = 0
        with pytest.raises(ActionFailed, match="was sent 'T' and answered 'ES': it does not know"):
            await driver.tare(GoalContext("t"))

    played(balance(emulator), story)


def test_silence_in_the_middle_is_a_timeout_and_names_what_was_asked(emulator):
    async def story(driver):
        emulator.silent = True
        with pytest.raises(ActionFailed) as failed:
            await weigh(driver)
        return failed.value

    failure = played(balance(emulator), story)

    assert failure.name == "Timeout"
    assert failure.message.startswith(f"balance on {emulator.link} (9600 baud, 8N1) was sent 'SI'")
    assert "was silent: is it on, is the cable plugged in" in failure.message


def test_unplugged_it_is_lost_and_plugged_in_again_it_goes_on_with_its_tare(emulator):
    async def story(driver):
        await driver.tare(GoalContext("t"))
        emulator.unplug()
        failures = []
        for _ in range(2):
            with pytest.raises(ActionFailed) as failed:
                await weigh(driver)
            failures.append(failed.value)
        with pytest.raises(ActionFailed, match="Lost"):
            await driver.status()
        emulator.plug()
        return failures, await weigh(driver)

    (first, second), reading = played(balance(emulator), story)

    assert {first.name, second.name} == {"Lost"}
    assert f"there is no port {emulator.link}: is the cable plugged in?" in second.message
    assert reading == {"mass": 0.0, "stable": True}


def test_another_balance_on_its_port_is_not_taken_for_it(emulator):
    async def story(driver):
        emulator.unplug()
        while driver._line.is_open:  # noqa: ASYNC110 - a thread sees it
            await asyncio.sleep(0.01)
        emulator.serial_number = "B000000001"
        emulator.plug()
        with pytest.raises(ActionFailed) as failed:
            await weigh(driver)
        return failed.value.message

    assert "is now B000000001, but was B123456789" in played(balance(emulator), story)


def test_a_balance_that_wakes_slowly_is_recognised_when_it_is_there(emulator):
    async def story(driver):
        emulator.unplug()
        while driver._line.is_open:  # noqa: ASYNC110 - a thread sees it
            await asyncio.sleep(0.01)
        emulator.serial_number, emulator.silent = "B000000001", True
        emulator.plug()
        with pytest.raises(ActionFailed, match=r"Timeout: .* was silent"):
            await weigh(driver)
        emulator.silent = False
        with pytest.raises(ActionFailed, match="is now B000000001"):
            await weigh(driver)

    played(balance(emulator), story)


def cannot_open(driver) -> str:
    with pytest.raises(OSError) as refused:
        asyncio.run(driver.open())
    return str(refused.value)


def test_a_wrong_baud_rate_says_that_what_came_is_no_text(emulator):
    words = cannot_open(balance(emulator, baud=4800))

    assert "(4800 baud, 8N1) was sent 'SI' and answered '\\\\xf8" in words
    assert "its baud rate, bits or parity may be different" in words


def test_another_device_on_the_port_is_quoted(emulator):
    emulator.says = "Grbl 1.1h ['$' for help]"

    assert "answered \"Grbl 1.1h ['$' for help]\", which is not MT-SICS: another device may be" in (
        cannot_open(balance(emulator))
    )


def test_a_balance_that_is_off_is_silent(emulator):
    emulator.silent = True

    assert "was sent 'SI' and was silent: is it on" in cannot_open(balance(emulator))


def test_bytes_that_it_cannot_read_are_its_own_word(emulator):
    emulator.says = "ET"

    assert "answered 'ET': it could not read the bytes" in cannot_open(balance(emulator))


def test_a_port_that_another_program_uses_is_a_sentence(emulator):
    async def story(driver):
        other = balance(emulator)
        with pytest.raises(OSError, match="is in use by another program"):
            await other.open()
        return await weigh(driver)

    assert played(balance(emulator), story)["stable"]


def test_what_is_no_serial_port_is_a_sentence(tmp_path):
    (tmp_path / "file").write_text("no port")
    config = {"port": str(tmp_path / "file")}

    assert "file is not a serial port" in cannot_open(
        Balance(Place("balance", config, {}, tmp_path, tmp_path))
    )


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({}, "config has no port"),
        (
            {"port": "/dev/ttyUSB0", "bauds": 9600},
            "config has no key bauds; its keys are: port, baud",
        ),
        ({"port": "/dev/ttyUSB0", "baud": "fast"}, "baud, bits, parity or stop_bits will not do"),
        ({"port": "/dev/ttyUSB0", "parity": "X"}, "Not a valid parity: 'X'"),
    ],
)
def test_a_configuration_that_will_not_do_is_refused_before_anything_is_opened(config, words):
    with pytest.raises(ValueError, match=words):
        Balance(Place("balance", config, {}, Path(), Path()))


def test_the_emulator_speaks_what_the_manual_says(tmp_path):
    emulator = BalanceEmulator(tmp_path / "unused")
    said = {line: emulator._perform(*line.partition(" ")[::2]) for line in (
        "S", "SI", "TI", "TA", "TAC", "TA 3 g", "TA x", "ZI", "@", "X", "I0",
    )}  # fmt: skip

    assert said["S"] == said["SI"] == ["S S    12.5000 g"]
    assert said["TI"] == ["TI S    12.5000 g"]
    assert said["TA"] == ["TA A    12.5000 g"]
    assert (said["TAC"], said["TA 3 g"], said["TA x"]) == (
        ["TAC A"],
        ["TA A     3.0000 g"],
        ["TA L"],
    )
    assert (said["ZI"], said["@"], said["X"]) == (["ZI +"], ['I4 A "B123456789"'], ["ES"])
    assert said["I0"][-1] == 'I0 A 0 "ZI"'
    assert emulator.baud == termios.B9600
