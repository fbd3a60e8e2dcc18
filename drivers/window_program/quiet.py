"""Keep the screen libraries from printing on stdout and from failing without need."""

import contextlib
import io
import os
import warnings
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def quiet_libraries() -> Iterator[None]:
    """While they are loaded: stdout belongs to the device server's one line, python-xlib prints there
    that it found no cookies, which is usual, and files that it and pyscreeze leave open are closed
    by the interpreter, not by us."""
    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        yield


def have_cookies() -> None:
    """python-xlib fails where there is no cookie file, even for a display that wants none."""
    cookies = Path.home() / ".Xauthority"
    if not os.environ.get("XAUTHORITY") and not cookies.exists():
        os.environ["XAUTHORITY"] = os.devnull
