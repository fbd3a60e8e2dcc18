"""A call of a function of one's own: a process of its own, which ends in time, whatever it does."""

import asyncio
import subprocess
import sys
import time
from pathlib import Path

import pytest

from labrun.engine.language.own_functions import read_function
from labrun.engine.run import function_calls
from labrun.engine.run.function_calls import FunctionFailed, call, call_at_once

OWN = """
import os, sys, time

def twice(x: float) -> float:
    print("a word on standard output")
    return 2 * x

def rows(x: float) -> list[dict[str, float]]:
    return [{"a": x}, {"a": None}]

def raises(x: float) -> float:
    def inner():
        raise KeyError("no such spectrum")
    return inner()

def exits(x: float) -> float:
    sys.exit("enough")

def dies(x: float) -> float:
    os._exit(7)

def hangs(x: float) -> float:
    while True:
        pass

def a_set(x: float) -> list:
    return {1, 2}

def text(x: float) -> float:
    return "2"

def nan(x: float) -> float:
    return float("nan")

def eats(x: float) -> float:
    return len(bytearray(1 << 40))

def session(x: float) -> int:
    return os.getsid(0)
"""


@pytest.fixture
def own(tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    return lambda name: read_function(name, f"own.py:{name}", tmp_path / "p.yaml", (tmp_path,))


def test_what_it_gives_comes_back(own):
    assert asyncio.run(call(own("twice"), {"x": 1.5})) == 3.0
    assert asyncio.run(call_at_once(own("rows"), {"x": 2})) == [{"a": 2}, {"a": None}]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("raises", r"raises: KeyError: 'no such spectrum' \(own.py, line 13\)"),
        ("exits", "SystemExit: enough"),
        ("dies", r"dies ended its process \(exit status 7\)"), ("a_set", "a_set: TypeError: it gave set"),
        ("text", "text gave '2', not a plain number"), ("nan", "not a finite number"),
        ("eats", "eats: MemoryError"),
    ],
)  # fmt: skip
def test_what_goes_wrong_in_it_is_told_in_a_sentence(own, name, words):
    with pytest.raises(FunctionFailed, match=words):
        asyncio.run(call(own(name), {"x": 1}))


@pytest.mark.parametrize("way", [call, call_at_once])
def test_one_that_does_not_end_is_ended(own, way):
    began = time.monotonic()
    with pytest.raises(FunctionFailed, match=r"hangs took longer than 0.5 s"):
        asyncio.run(way(own("hangs"), {"x": 1}, 0.5))

    assert time.monotonic() - began < 30


def test_one_whose_engine_was_killed_ends_by_itself(own, monkeypatch):
    monkeypatch.setattr(function_calls, "BEHIND_S", 0.5)
    asked = function_calls._asked(own("hangs"), {"x": 1}, 0.1)
    done = subprocess.run(
        function_calls.COMMAND, input=asked, capture_output=True, timeout=60, check=False
    )

    assert done.returncode != 0
    assert b"Timeout" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no sessions")
def test_it_does_not_hear_what_is_typed_at_the_engine(own):
    import os

    assert asyncio.run(call(own("session"), {"x": 1})) != os.getsid(0)


def test_its_process_needs_nothing_of_labrun():
    lines = Path(function_calls.COMMAND[-1]).read_text().splitlines()
    imported = [line.split()[1] for line in lines if line.startswith(("import ", "from "))]

    assert imported == ["contextlib", "faulthandler", "json", "sys"]
