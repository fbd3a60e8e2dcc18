"""A reader that is installed on request, by the extra `formats`."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ....system.extras import absent, not_installed
from ..fault import Unreadable


def library(name: str, what: str) -> ModuleType:
    """The module. Raises Unreadable, with the way to install it."""
    try:
        return import_module(name)
    except ImportError as fault:
        raise Unreadable(_lacks(what, not_installed(fault) or str(fault))) from None


def lacking(name: str, what: str) -> str | None:
    """The same words where the module is not installed, without loading it; None where it is."""
    why = absent(name)
    return None if why is None else _lacks(what, why)


def _lacks(what: str, why: str) -> str:
    return f"this is {what}; its reader {why} (or export the spectrum as text)"


def spoiled(what: str, fault: BaseException) -> Unreadable:
    """The error for a file that its reader cannot take."""
    words = " ".join(str(fault).split())[:160] or type(fault).__name__
    return Unreadable(f"this is {what}, but its reader stopped: {words}; is the file complete?")


@contextmanager
def on_disk(raw: bytes, suffix: str) -> Iterator[Path]:
    """A file with these bytes, for a reader that takes paths only."""
    with tempfile.TemporaryDirectory(prefix="labrun-") as folder:
        path = Path(folder) / f"spectrum{suffix}"
        path.write_bytes(raw)
        yield path
