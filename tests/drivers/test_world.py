"""Twins in several processes see whole states of each other, and the truth is only added to."""

import subprocess
import sys

import pytest

from labrun.drivers.world import World, WorldInMemory


def test_nobody_has_published_anything_yet(tmp_path):
    assert World(tmp_path).look("gantry") is None


@pytest.mark.slow
def test_another_process_sees_only_whole_states(tmp_path):
    script = f"""
import pathlib
from labrun.drivers.world import World
world = World(pathlib.Path({str(tmp_path)!r}))
for n in range(3000):
    world.publish("gantry", {{"n": n, "twice": 2 * n, "ballast": "x" * (n % 500)}})
"""
    world, seen = World(tmp_path), set()
    with subprocess.Popen([sys.executable, "-c", script]) as process:
        while process.poll() is None:
            state = world.look("gantry")
            if state is not None:
                assert state["twice"] == 2 * state["n"]
                seen.add(state["n"])
    last = world.look("gantry")

    assert process.returncode == 0
    assert last is not None
    assert last["n"] == 2999
    assert len(seen) > 1


@pytest.mark.parametrize("in_memory", [False, True])
def test_the_log_numbers_its_lines_and_finds_them_again(tmp_path, in_memory):
    truth = (WorldInMemory() if in_memory else World(tmp_path)).truth("libs")
    truth.open()
    truth.append("shot", goal="a", x=1.5)
    truth.append("shot", goal="ä", x=2.5)
    entries = list(truth.entries())
    second = truth.entry(2)
    missing = [truth.entry(n) for n in (0, 3, -1)]
    truth.close()

    assert [(e["n"], e["what"], e["goal"], e["x"]) for e in entries] == [
        (1, "shot", "a", 1.5),
        (2, "shot", "ä", 2.5),
    ]
    assert second == entries[1]
    assert missing == [None, None, None]


def test_the_log_goes_on_after_a_restart_and_drops_a_torn_line(tmp_path):
    truth = World(tmp_path).truth("libs")
    truth.open()
    truth.append("shot", goal="a")
    truth.close()
    with truth.path.open("ab") as file:
        file.write(b'{"n": 2, "wh')

    again = World(tmp_path).truth("libs")
    again.open()
    again.append("shot", goal="b")
    found = again.entry(2)
    again.close()

    assert [entry["goal"] for entry in again.entries()] == ["a", "b"]
    assert found is not None
    assert found["goal"] == "b"


def test_a_closed_log_takes_nothing(tmp_path):
    with pytest.raises(ValueError, match=r"libs\.jsonl is not open"):
        World(tmp_path).truth("libs").append("shot")
