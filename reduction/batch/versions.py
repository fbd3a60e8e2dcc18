"""The versions of all software that the numbers in a table depend on."""

import platform
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("labrun", "numpy", "numba", "scipy", "pyarrow")


def versions() -> dict[str, str]:
    """Names and versions of Python and the installed packages."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"
