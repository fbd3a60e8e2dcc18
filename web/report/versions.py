"""Installed versions of labrun, Python, and every package that labrun and its extras need."""

import platform
import re
from importlib.metadata import PackageNotFoundError, requires, version

from ... import __version__

FOR_TESTS = ("extra == 'test'", 'extra == "test"')
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def installed_versions() -> dict[str, str]:
    """Package -> version, labrun and Python first; only installed packages."""
    found = {"labrun": __version__, "Python": platform.python_version()}
    for name in sorted(_needed(), key=str.lower):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def machine() -> str:
    """Operating system and architecture; no user or host name."""
    return f"{platform.system()} {platform.release()}, {platform.machine()}"


def _needed() -> set[str]:
    try:
        told = requires("labrun") or []
    except PackageNotFoundError:
        return set()
    found = (NAME.match(line) for line in told if not line.endswith(FOR_TESTS))
    return {match[0] for match in found if match is not None} - {"labrun"}
