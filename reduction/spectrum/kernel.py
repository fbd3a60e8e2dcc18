"""Inner loops compiled by numba, once per user: the compiled code is in the user's cache folder.

Beside the module, numba's default, it would outlive an uninstall and mask the next installation.
numba compiles a loop again when its own file changes, not when a loop that it calls changes in another
file, and then goes on with the old one. So every state of the sources has a folder of its own,
wherever they lie: the same labrun installed once more finds what was compiled.

Nothing is compiled twice: of processes that want the same loop at once, one compiles it, the others
wait and load it.
"""

import hashlib
import os
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from ...system.files import lock_file

PACKAGE = Path(__file__).parent.parent
WAIT_S, LOOK_S = 300.0, 0.02  # for a loop that another process compiles: seconds, even the longest


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
from numba.core import caching, config, event  # noqa: E402


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


class CompiledOnce(caching.FunctionCache):
    """What was compiled of one loop. Whoever does not find it keeps others waiting until it is there.

    A loop is locked before those that it calls, in every process, so no two wait for each other.
    """

    _file: IO[str] | None = None
    _compiling = 0

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        found = super().load_overload(sig, target_context)
        if found is None:
            self._lock()
            found = super().load_overload(sig, target_context)  # of whom was waited for
            if found is not None:
                self.unlock()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        finally:
            self.unlock()

    def _lock(self) -> None:
        self._compiling += 1
        if self._compiling > 1:
            return
        path = Path(self.cache_path) / f"{self._impl.filename_base}.lock"
        with suppress(OSError):  # where nothing can be locked it may be compiled twice
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("w", encoding="utf-8")
            _wait_for(self._file)

    def unlock(self) -> None:
        """It is saved now, or it could not be compiled."""
        self._compiling -= 1
        if self._compiling == 0 and self._file is not None:
            self._file.close()
            self._file = None


def _wait_for(file: IO[str]) -> None:
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        try:
            lock_file(file)
            break
        except (BlockingIOError, PermissionError):  # the second on Windows
            time.sleep(LOOK_S)


class _Failures(event.Listener):
    """Nobody waits for what could not be compiled."""

    def on_start(self, event: event.Event) -> None: ...

    def on_end(self, event: event.Event) -> None:
        cache = (event.data or {})["dispatcher"]._cache
        # Not `is_failed`, which numba to 0.68 says the wrong way round.
        if event._exc_details is not None and isinstance(cache, CompiledOnce):
            cache.unlock()


event.register("numba:compile", _Failures())


def _kernel(**more: Any) -> Callable[[Callable], Any]:
    """A decorator. Nothing of ours is called by an address in C: that wrapper is never built."""
    options: Any = {"error_model": "numpy", "no_cfunc_wrapper": True, **more}
    jit = numba.njit(cache=True, nogil=True, **options)

    def compiled(function: Callable) -> Any:
        kernel: Any = jit(function)
        kernel._cache = CompiledOnce(function)
        return kernel

    return compiled


kernel = _kernel()
"""Compile a function on its first call; other threads keep running while it compiles and runs.

A division by zero gives infinity, as in numpy, instead of an error.
"""

inner_kernel = _kernel(no_cpython_wrapper=True)
"""The same, for a function that only others of these call: Python cannot, which spares a third."""

sum_kernel = _kernel(no_cpython_wrapper=True, fastmath={"reassoc", "contract", "nsz"})
"""As an inner one, and sums are added several terms side by side, in the order that suits the processor."""

part_kernel = _kernel(no_cpython_wrapper=True, inline="always")
"""As an inner one of which there is one caller: it is compiled within that, and not by itself as well."""
