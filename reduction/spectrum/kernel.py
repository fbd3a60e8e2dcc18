"""Inner loops compiled by numba, once per user: the compiled code is in the user's cache folder.

Beside the module, numba's default, it would outlive an uninstall and mask the next installation.
numba compiles a loop again when its own file changes, not when a loop that it calls changes in another
file, and then goes on with the old one. So every state of the sources has a folder of its own,
wherever they lie: the same labrun installed once more finds what was compiled.
"""

import hashlib
import os
import sys
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).parent.parent


def cache_folder() -> Path:
    """Folder of compiled code; a temporary folder if the user's own is read-only."""
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", home / ".cache"))
    state = state_of(PACKAGE)
    folder = base / "labrun" / "numba" / state
    try:
        folder.mkdir(parents=True, exist_ok=True)
        writable = os.access(folder, os.W_OK)
    except OSError:
        writable = False
    return folder if writable else Path(tempfile.gettempdir()) / f"labrun-numba-{state}"


def state_of(package: Path) -> str:
    """Short name of what its source files say now."""
    found = hashlib.sha256()
    for path in sorted(package.glob("*/*.py")):  # no loop lies deeper, or at the root
        found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()[:12]


os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder()))

import numba  # noqa: E402  # it reads the folder's name when it is imported
from numba.core import caching, config  # noqa: E402


class ByContents(caching.UserProvidedCacheLocator):
    """Where compiled code lies does not depend on where its source does."""

    @classmethod
    def from_function(cls, py_func, py_file):
        return super().from_function(py_func, py_file) if PACKAGE in Path(py_file).parents else None

    @classmethod
    def get_suitable_cache_subpath(cls, py_file):
        return Path(py_file).parent.name


# numba before 0.62 knows no such list, and compiles once for every place.
_KNOWN = [cls.__name__ for cls in caching.CacheImpl._locator_classes]
_LOCATORS = ",".join([f"{__name__}.ByContents", *_KNOWN])
config.CACHE_LOCATOR_CLASSES = _LOCATORS  # pyright: ignore[reportAttributeAccessIssue]

kernel = numba.njit(cache=True, nogil=True)
"""Compile a function on its first call; other threads keep running while it compiles and runs."""

float_kernel = numba.njit(cache=True, nogil=True, error_model="numpy")
"""The same, but a division by zero gives infinity, as in numpy, instead of an error."""

sum_kernel = numba.njit(
    cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"}
)
"""The same, and sums are added several terms side by side, in the order that suits the processor."""
