"""Random protocols, killed again and again: their outcome is what the oracle predicts.

With LABRUN_RANDOM=1 every run of these tests draws others.
"""

import os

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st

RANDOM = bool(os.environ.get("LABRUN_RANDOM"))
TRIES = 30
"""At most this many times a person resumes a run that has failed."""


def examples(count):
    return settings(
        max_examples=count, deadline=None, derandomize=not RANDOM, database=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip


@pytest.fixture(scope="session")
def survives(laboratory, strategies, oracle, promise):
    """Play a story of crashes, and check that every part of the promise was kept."""

    def check(protocol, answers, kills, *, tries=0):
        told = oracle(answers)
        status = told.run(strategies.patient(protocol) if tries else protocol)
        story = laboratory.live(protocol, kills, answers, tries)
        note(story.tell())
        promise.kept(story, told, status, protocol, tries)

    return check


@examples(6)
@given(data=st.data())
def test_a_run_comes_to_the_same_whenever_its_engines_are_killed(survives, strategies, data):
    survives(*data.draw(strategies.engine_dies()))


@pytest.mark.soak
@examples(8)
@given(data=st.data())
def test_a_run_comes_to_the_same_when_its_devices_are_touched_meanwhile(survives, strategies, data):
    survives(*data.draw(strategies.devices_are_touched()))


@pytest.mark.slow
@examples(8)
@given(data=st.data())
def test_a_run_comes_to_the_same_when_the_device_server_dies_in_mid_action(
    survives, strategies, data
):
    survives(*data.draw(strategies.server_dies()))


@pytest.mark.soak
@examples(6)
@given(data=st.data())
def test_a_run_that_failed_and_is_resumed_comes_to_the_same_in_the_end(survives, strategies, data):
    survives(*data.draw(strategies.run_fails()), tries=TRIES)


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize("story", ["engine_dies", "devices_are_touched", "server_dies"])
@examples(40)
@given(data=st.data())
def test_a_run_comes_to_the_same_after_many_crashes(survives, strategies, story, data):
    survives(*data.draw(getattr(strategies, story)()))


@pytest.mark.soak
@pytest.mark.timeout(600)
@examples(20)
@given(data=st.data())
def test_a_run_that_failed_comes_to_the_same_after_many_crashes(survives, strategies, data):
    survives(*data.draw(strategies.run_fails()), tries=TRIES)
