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
        good={"zero": {}, "tare": {}, "last_tare": {}, "weigh": {"patience": 2.5}},
        bad={"weigh": [{"patience": "10 s"}]},
        lasting="weigh",
    )

    @contextmanager
    def peer(self, folder, *, slow):
        settles_after = 12 if slow else 0
        with BalanceEmulator(folder / "balance", settles_after=settles_after, load_g=2.0) as peer:
            self.emulator = peer
            yield {"port": str(peer.link)}

    def happened(self, folder, goal_id):
        return self.emulator.set > 0


@pytest.fixture
def emulator(tmp_path):
    with BalanceEmulator(tmp_path / "balance") as emulator:
        yield emulator


def balance(emulator: BalanceEmulator, **config) -> Balance:
    config = {"port": str(emulator.link), **config}
    folder = emulator.link.parent / "server"
    folder.mkdir(exist_ok=True)
    return Balance(Place("balance", config, {}, folder, Path()))


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


@pytest.mark.parametrize(
    ("action", "lost", "tare_g", "net_g", "told"),
    [
        ("tare", "answer", 0.0, 12.5, "r/t/1"),
        ("tare", "answer", 12.5, 0.25, "r/t/1"),
        ("tare", "command", 0.0, 12.5, "r/before/1"),
        ("tare", "command", 12.5, 0.25, "r/before/1"),
        ("tare", "answer", 12.5, 0.0, None),  # the tare memory is as it was
        ("zero", "command", 1.0, 0.5, "r/before/1"),  # it would be empty
        ("zero", "answer", 1.0, 0.5, None),  # it is empty: by that, or for it was switched off
        ("zero", "answer", 0.0, 0.5, None),
    ],
)
def test_its_tare_memory_tells_whether_a_tare_whose_answer_got_lost_was_done(
    emulator, monkeypatch, action, lost, tare_g, net_g, told
):
    monkeypatch.setattr("labrun.drivers.balance.driver.PATIENCE_S", 0.5)

    async def story(driver):
        emulator.load_g = tare_g
        await driver.tare(GoalContext("r/before/1"))
        emulator.load_g += net_g
        emulator.lost = lost
        with pytest.raises(ActionFailed, match="Timeout"):
            await getattr(driver, action)(GoalContext("r/t/1"))

    async def probed(driver):
        emulator.load_g += 1  # what is on the pan by then does not matter
        return await driver.last_tare(GoalContext("p")), await driver.last_tare(GoalContext("q"))

    played(balance(emulator), story)
    emulator.silent, emulator.lost = False, ""
    first, again = played(balance(emulator), probed)

    assert first == again and first["goal_id"] == told
    if told == "r/t/1":
        assert first["tare"] == tare_g + net_g


def test_one_whose_end_is_not_known_is_not_hidden_by_one_that_was_refused(emulator, monkeypatch):
    monkeypatch.setattr("labrun.drivers.balance.driver.PATIENCE_S", 0.5)

    async def story(driver):
        emulator.lost = "answer"
        with pytest.raises(ActionFailed, match="Timeout"):
            await driver.tare(GoalContext("r/t/1"))
        emulator.silent, emulator.lost, emulator.load_g = False, "", 30.0
        with pytest.raises(ActionFailed, match="NotEmpty"):
            await driver.zero(GoalContext("call/z/1"))
        return (await driver.last_tare(GoalContext("p")))["goal_id"]

    assert played(balance(emulator), story) == "r/t/1"


@pytest.mark.parametrize(
    ("by", "words"),
    [
        ("off", r"its tare was 12\.5 g when r/t/1 had set it, and is 0 g now: it was switched off"),
        ("call", r"call/z/1 has zeroed or tared it since r/t/1"),
        ("nobody", ""),
    ],
)
def test_a_run_whose_tare_no_longer_holds_is_told_and_gets_no_mass(emulator, by, words):
    async def tare(driver):
        await driver.tare(GoalContext("r/t/1"))

    async def weigh(driver):
        emulator.load_g = 2.0
        if by == "call":
            await driver.zero(GoalContext("call/z/1"))
        emulator.tare_g = 0.0 if by == "off" else emulator.tare_g
        if words:
            with pytest.raises(ActionFailed, match=f"TareLost: {words}"):
                await driver.weigh(GoalContext("r/w/1"))
        return (await driver.weigh(GoalContext("other/w/1")))["mass"]

    played(balance(emulator), tare)

    assert played(balance(emulator), weigh) == {"off": 2.0, "call": 0.0, "nobody": -10.5}[by]


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
        with pytest.raises(ActionFailed, match="was sent 'TA' and answered 'ES': it does not know"):
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


@pytest.mark.parametrize(
    ("says", "words"),
    [("ET", "it could not read the bytes"), ("S S Error 10b", "a fault of its own")],
)
def test_bytes_that_it_cannot_read_and_faults_are_its_own_word(emulator, says, words):
    emulator.says = says

    assert f"answered {says!r}: {words}" in cannot_open(balance(emulator))


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
        ({"port": "/dev/ttyUSB0", "baud": "fast"}, "baud is 'fast', which will not do"),
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
