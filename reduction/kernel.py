"""Inner loops compiled by numba, once a user: the compiled code lies in the user's cache folder.

Beside the module, numba's default, it would outlive an uninstall and hide what is installed next.
"""

import os
import sys
import tempfile
from pathlib import Path


def cache_folder() -> Path:
    """Where compiled code is kept; a folder for temporary files where the user's own is read-only."""
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", home / ".cache"))
    folder = base / "labrun" / "numba"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return Path(tempfile.gettempdir()) / "labrun-numba"
    return folder if os.access(folder, os.W_OK) else Path(tempfile.gettempdir()) / "labrun-numba"


os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))

import numba  # noqa: E402  # it reads the folder's name when it is imported

kernel = numba.njit(cache=True, nogil=True)
"""Compile a function on its first call; other threads go on meanwhile and while it runs."""

float_kernel = numba.njit(cache=True, nogil=True, error_model="numpy")
"""The same, where a division by zero is infinite, as in numpy, and not an error."""
