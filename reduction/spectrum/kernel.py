"""Inner loops compiled by numba, once per user: the compiled code is in the user's cache folder.

Beside the module, numba's default, it would outlive an uninstall and mask the next installation.
numba compiles a loop again when its own file changes, not when a loop that it calls changes in another
file, and then goes on with the old one. So every state of the sources has a folder of its own.
"""

import hashlib
import os
import sys
import tempfile
from pathlib import Path


def cache_folder() -> Path:
    """Folder of compiled code; a temporary folder if the user's own is read-only."""
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", home / ".cache"))
    folder = base / "labrun" / "numba" / state_of(Path(__file__).parent.parent)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return Path(tempfile.gettempdir()) / "labrun-numba"
    return folder if os.access(folder, os.W_OK) else Path(tempfile.gettempdir()) / "labrun-numba"


def state_of(package: Path) -> str:
    """Short name of what its source files are now, by their paths, sizes and times."""
    found = hashlib.sha256(str(package).encode())
    for path in sorted(package.glob("*/*.py")):  # no loop lies deeper, or at the root
        about = path.stat()
        found.update(f"{path.name} {about.st_size} {about.st_mtime_ns};".encode())
    return found.hexdigest()[:12]


os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))

import numba  # noqa: E402  # it reads the folder's name when it is imported

kernel = numba.njit(cache=True, nogil=True)
"""Compile a function on its first call; other threads keep running while it compiles and runs."""

float_kernel = numba.njit(cache=True, nogil=True, error_model="numpy")
"""The same, but a division by zero gives infinity, as in numpy, instead of an error."""

sum_kernel = numba.njit(
    cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"}
)
"""The same, and sums are added several terms side by side, in the order that suits the processor."""
