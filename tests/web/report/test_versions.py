"""A report names the versions of everything that labrun needs."""

from labrun import __version__
from labrun.web.report.versions import installed_versions, machine


def test_labrun_python_and_what_labrun_needs_are_named_and_test_tools_are_not():
    found = installed_versions()

    assert list(found)[:2] == ["labrun", "Python"]
    assert found["labrun"] == __version__
    assert {"numpy", "scipy", "py_trees", "python-socketio", "pydantic"} <= set(found)
    assert "pytest" not in found


def test_the_machine_is_told_without_its_name():
    import platform

    assert platform.machine() in machine()
    assert platform.node() not in machine() or not platform.node()
