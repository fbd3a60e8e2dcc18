"""Random protocols, killed again and again: what they come to is what the oracle says.

With LABRUN_RANDOM=1 every run of these tests draws others.
"""

import os

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

RANDOM = bool(os.environ.get("LABRUN_RANDOM"))


def examples(count):
    return settings(
        max_examples=count, deadline=None, derandomize=not RANDOM, database=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip


@pytest.fixture(scope="session")
def survives(laboratory, oracle, promise):
    """Live a story of crashes, and see that every part of the promise was kept."""

    def check(protocol, answers, kills):
        told = oracle(answers)
        status = told.run(protocol)
        story = laboratory.live(protocol, kills, answers)
        note(story.tell())
        promise.kept(story, told, status, protocol)

    return check


@examples(24)
@given(data=st.data())
def test_a_run_comes_to_the_same_whenever_its_engines_are_killed(survives, strategies, data):
    survives(*data.draw(strategies.engine_dies()))


@examples(10)
@given(data=st.data())
def test_a_run_comes_to_the_same_when_its_devices_are_touched_meanwhile(survives, strategies, data):
    survives(*data.draw(strategies.devices_are_touched()))


@examples(10)
@given(data=st.data())
def test_a_run_comes_to_the_same_when_the_device_server_dies_in_mid_action(
    survives, strategies, data
):
    survives(*data.draw(strategies.server_dies()))


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("story", ["engine_dies", "devices_are_touched", "server_dies"])
@examples(600)
@given(data=st.data())
def test_a_run_comes_to_the_same_after_hundreds_of_crashes(survives, strategies, story, data):
    survives(*data.draw(getattr(strategies, story)()))
