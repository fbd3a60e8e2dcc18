"""The laboratory in which runs are killed: one server, one process that forks engines."""

import importlib.util
import sys
from pathlib import Path

import pytest


def load(name):
    """A file beside this one: the tests are not a package."""
    spec = importlib.util.spec_from_file_location(
        f"crashes_{name}", Path(__file__).with_name(f"{name}.py")
    )
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


for part in ("walk", "naming", "draws", "oracle_acts", "oracle_blocks"):
    load(part)  # what the others import, by the name `crashes_...`


@pytest.fixture(scope="session")
def laboratory(tmp_path_factory):
    lab = load("sessions").Laboratory(tmp_path_factory.mktemp("crashes"))
    yield lab
    lab.close()


@pytest.fixture(scope="session")
def strategies():
    return load("strategies")


@pytest.fixture(scope="session")
def oracle():
    """The interpreter of a protocol: called with the answers, it has not seen a protocol yet."""
    return load("oracle").Oracle


@pytest.fixture(scope="session")
def promise():
    return load("promise")
