"""The contract tests pass a lamp that keeps its word, and catch each one that does not."""

import asyncio
import time
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.contract_tests.bad_calls import bad_calls
from labrun.drivers.contract_tests.session import Session
from labrun.schemas.contract import Action

HERE = Path(__file__).parent


def case_of(lamp: str, seconds: float = 3) -> Case:
    return Case(
        driver=f"{HERE / 'lamps.py'}:{lamp}",
        contract=HERE / "lamp.yaml",
        config={"slow": True},
        good={"glow": {"seconds": seconds}, "flash": {}, "last_flash": {}, "dark": {}},
        lasting="glow",
    )


class LampTest(KeepsContract):
    def is_safe(self, status):
        return not status["lit"]


class TestLamp(LampTest):
    case = case_of("Lamp")


GOOD = "test_a_good_call_succeeds"
CANCEL = "test_a_cancellable_action_ends_when_it_is_cancelled"
DEADLINE = "test_past_its_deadline_a_goal_is_cancelled_or_goes_on_to_its_end"
STOP = "test_a_stop_ends_what_runs_and_leaves_the_device_safe"
GONE = "test_when_its_engine_is_gone_it_does_what_the_contract_says"
PROBE = "test_after_a_kill_behind_a_once_action_its_probe_says_what_is_true"
STILL = "test_a_probe_of_a_once_action_that_may_still_go_on_waits_or_does_not_know"
DESCRIBE = "test_it_describes_itself_as_its_contract_says"


@pytest.mark.parametrize(
    ("lamp", "test", "action", "words"),
    [
        pytest.param("Deaf", CANCEL, "glow", "6 s later it has not ended", marks=pytest.mark.slow),
        ("Stubborn", CANCEL, "glow", "glow was cancelled and ended"),
        ("Stubborn", DEADLINE, None, "glow was cancelled and ended"),
        ("Stubborn", GONE, None, "it should have been cancelled, but ended"),
        ("Babbling", DESCRIBE, None, "'bright' is not of type 'boolean'"),
        ("Mute", GOOD, "dark", "RuntimeError: no idea"),
        ("Wrong", GOOD, "glow", "'many' is not of type 'number'"),
        ("Unsafe", STOP, None, "may not be safe: RuntimeError: the switch is worn"),
        ("Glaring", STOP, None, "it was stopped, but reports {'lit': True}"),
        ("Forgetful", PROBE, "flash", "last_flash: {'goal_id': ''}"),
        ("Dark", PROBE, "flash", "flash never happened"),
    ],
)
def test_a_broken_promise_is_found_and_said(tmp_path, lamp, test, action, words):
    class Broken(LampTest):
        case = case_of(lamp)

    with pytest.raises(AssertionError) as failed:
        getattr(Broken(), test)(tmp_path, **({} if action is None else {"action": action}))

    assert words in str(failed.value)


def test_a_probe_that_denies_what_is_still_to_come_is_found(tmp_path, monkeypatch):
    truth, begin = tmp_path / "world" / "truth", Session.begin

    async def begun(session, action, timeout_s=None):
        made = await begin(session, action, timeout_s)
        while not (truth / "asked").exists():  # noqa: ASYNC110 - of another process
            await asyncio.sleep(0.01)
        return made

    monkeypatch.setattr(Session, "begin", begun)

    class Broken(LampTest):
        case = case_of("Overtaken")

        def rest(self, folder):
            """Let the instrument, which has outlived its server, do what it was asked for."""
            (truth / "go").touch()
            while not list(truth.glob("*.jsonl")):
                time.sleep(0.01)

    with pytest.raises(AssertionError, match="it must wait while the instrument is busy"):
        getattr(Broken(), STILL)(tmp_path, action="flash")


def test_an_action_that_is_over_too_soon_is_told_how_to_be_slow(tmp_path, monkeypatch):
    monkeypatch.setattr("labrun.drivers.contract_tests.session.MOMENT_S", 500)

    class Hasty(LampTest):
        case = case_of("Lamp", seconds=0.1)

    with pytest.raises(AssertionError, match=r"glow was over within .* `slow` must make it last"):
        getattr(Hasty(), STOP)(tmp_path)


def test_a_good_call_that_is_missing_is_said():
    class Short(LampTest):
        case = Case(driver=f"{HERE / 'lamps.py'}:Lamp", contract=HERE / "lamp.yaml",
                    good={"glow": {"seconds": 1}}, lasting="glow")  # fmt: skip

    with pytest.raises(AssertionError, match="one call of each action"):
        Short().test_the_driver_has_what_its_contract_wants_and_each_action_a_good_call()


def test_bad_calls_follow_from_the_schema():
    action = Action.model_validate({
        "params": {
            "type": "object",
            "additionalProperties": False,
            "required": ["x"],
            "properties": {
                "x": {"type": "number", "minimum": 0, "maximum": 10},
                "feed": {"type": "number", "exclusiveMinimum": 0},
                "mode": {"type": "string", "enum": ["a", "b"]},
                "file": {"type": "string", "format": "path"},
            },
        },
    })  # fmt: skip
    calls = dict(bad_calls(action, {"x": 1}, {"x": (None, 5.0)}))

    assert calls["x beyond its maximum"] == {"x": 6.0}
    assert calls["x missing"] == {}
    assert calls["feed at its exclusiveMinimum"] == {"x": 1, "feed": 0}
    assert calls["mode not on the list"]["mode"] == "no such word"
    assert calls["file outside the run's folder"]["file"] == "../outside.txt"
    assert {"an unknown parameter", "x NaN", "x infinite", "x of another type"} <= calls.keys()


def test_a_test_that_waits_is_an_ordinary_function():
    assert not asyncio.iscoroutinefunction(KeepsContract.test_a_good_call_succeeds)


def test_pytest_is_not_needed_to_read_it():
    import subprocess
    import sys

    code = "import sys, labrun.drivers.contract_tests; print('pytest' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert said.stdout == "False\n"
