"""Parameters and answers are held against the contract, the bench's limits, and what a file is."""

import subprocess
import sys
from hashlib import sha256

import pytest

from labrun.drivers.server.arguments import Arguments, LimitFault, narrowed, read_limits
from labrun.schemas.contract import Contract
from labrun.schemas.messages import FileContent, Goal

MOVE = {
    "type": "object",
    "properties": {
        "x": {"type": "number", "unit": "mm", "minimum": 0, "maximum": 730},
        "file": {"type": "string", "format": "path"},
        "source": {"type": "string", "format": "path"},
    },
}
CONTRACT = Contract(
    type="gantry@1",
    actions={
        "move": {
            "params": MOVE,
            "returns": {"properties": {"file": {"type": "string", "format": "path"}}},
        },
        "halt": {},
    },
)


def fault_in(params, files=None, limits=None, action="move"):
    arguments = Arguments(f"gantry.{action}", CONTRACT.actions[action], limits or {})
    return arguments.fault_in(
        Goal(
            id="g",
            device="gantry",
            boot="",
            epoch=1,
            action=action,
            params=params,
            files=files or {},
        )
    )


def a_file(data=b"abc", told=None):
    return FileContent(path="a.csv", sha256=told or sha256(data).hexdigest(), data=data)


def test_nan_is_refused_though_it_is_neither_below_nor_above_anything():
    assert (
        fault_in({"x": float("nan")})
        == "gantry.move.x: nan is not a number that JSON can represent"
    )


def test_what_the_contract_allows_is_no_fault():
    assert fault_in({"x": 730, "source": "a.csv"}, {"source": a_file()}) is None


def test_an_action_without_parameters_takes_none():
    assert fault_in({}, action="halt") is None
    assert "'x' was unexpected" in fault_in({"x": 1}, action="halt")


def test_limits_only_ever_narrow():
    wide = narrowed(MOVE, {"x": (-5, 900)})["properties"]["x"]
    tight = narrowed(MOVE, {"x": (10, 20), "nowhere": (1, 2)})["properties"]["x"]

    assert (wide["minimum"], wide["maximum"]) == (0, 730)
    assert (tight["minimum"], tight["maximum"]) == (10, 20)


@pytest.mark.parametrize("written", [{"minimum": "1 cm", "maximum": 20}, [10, 20], ["1 cm", 20]])
def test_limits_are_read_in_the_contracts_units(written):
    assert read_limits({"x": written}, CONTRACT) == {"x": (10, 20)}


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ({"q": [0, 1]}, "limit q: no action of gantry@1 has such a parameter"),
        ({"x": ["3 s", None]}, "limit x: 3 s is a time, wanted is a length"),
        ({"x": [True, None]}, "limit x: True is not a number"),
    ],
)
def test_limits_that_make_no_sense_are_sentences(written, words):
    with pytest.raises(LimitFault) as caught:
        read_limits(written, CONTRACT)

    assert words in str(caught.value)


@pytest.mark.parametrize(
    "path", ["/etc/passwd", "../up.csv", "a/../../b", "C:\\x", "\\\\host\\x", ""]
)
def test_a_path_never_leaves_the_runs_folder(path):
    assert "is outside the run's folder" in fault_in({"file": path})


def test_a_file_that_is_read_must_come_along_undamaged():
    assert "the file a.csv was not sent along" in fault_in({"source": "a.csv"})
    assert "was damaged in transfer" in fault_in(
        {"source": "a.csv"}, {"source": a_file(told="0" * 64)}
    )


def test_an_answer_must_bring_the_files_that_it_names():
    arguments = Arguments("gantry.move", CONTRACT.actions["move"], {})

    assert arguments.fault_out({"file": "out.csv"}, {"file": a_file()}) is None
    assert "the file out.csv was not sent along" in arguments.fault_out({"file": "out.csv"}, {})
    assert "answered list, the contract requires an object" in arguments.fault_out([], {})
    assert arguments.fault_out({"z": b"x"}, {}).endswith(
        "gantry.move.z: a bytes is not a JSON type"
    )


def test_a_good_goal_is_checked_without_the_library_that_takes_seconds_to_load():
    """Beside Jupyter it builds a grammar first, and the server would hear no stop meanwhile."""
    program = """
import sys
from labrun.drivers.server.arguments import Arguments
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.messages import Goal

home = shipped_contracts()["gantry@1"].actions["move_to"]
goal = Goal(id="g", device="gantry", action="move_to", boot="b", epoch=1, params={"x": 1.5})
arguments = Arguments("gantry.move_to", home, {"x": (0.0, 400.0)})
assert arguments.fault_in(goal) is None
assert arguments.fault_out({"x": 1.5, "y": 0.0, "z": 0.0}, {}) is None
print("jsonschema" in sys.modules)
"""
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)

    assert (told.stdout, told.stderr) == ("False\n", "")
