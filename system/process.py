"""Processes: start Python ones of our own, apart from the terminal, end them in time, see who lives."""

import asyncio
import contextlib
import getpass
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypedDict

from . import WINDOWS

# What Windows calls SIGTERM ends a process at once, with whatever it was doing half done.
PLEASE_END = getattr(signal, "CTRL_BREAK_EVENT", signal.SIGTERM)
AT_ONCE = getattr(signal, "SIGKILL", signal.SIGTERM)
Process = asyncio.subprocess.Process
MAY_ASK, ACCESS_DENIED, STILL_ACTIVE = 0x1000, 5, 259
"""Windows': PROCESS_QUERY_LIMITED_INFORMATION, ERROR_ACCESS_DENIED and STILL_ACTIVE."""


def user_name() -> str:
    """Who has started this process; in a container that knows no name for its user, the number."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return f"user {os.getuid()}" if hasattr(os, "getuid") else "somebody"


async def start_python(
    module: str, *arguments: str, python: str | None = None, **options: Any
) -> Process:
    """Start a module with this Python, or another one; raises OSError.

    Ctrl-C in the terminal is not for it, it has no input, and what it says is UTF-8; `options`
    (`stdout`, `env`, ...) are those of subprocess, and come first.
    """
    options["env"] = in_utf8(options.get("env") or os.environ)
    defaults = {"stdin": subprocess.DEVNULL, **apart()}
    return await asyncio.create_subprocess_exec(
        python or sys.executable, "-P", "-m", module, *arguments, **{**defaults, **options}
    )


def in_utf8(environment: Mapping[str, str]) -> dict[str, str]:
    """An environment in which Python writes UTF-8 into pipes and files: on Windows it is the code page."""
    return {**environment, "PYTHONIOENCODING": "utf-8"}


class Apart(TypedDict, total=False):
    """Options of subprocess."""

    creationflags: int
    start_new_session: bool


def apart() -> Apart:
    """The options of subprocess that give a process its own session: signals are not shared."""
    if WINDOWS:
        return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}
    return {"start_new_session": True}


async def stop(process: Process, timeout_s: float) -> int | None:
    """Ask it to end, and kill it after `timeout_s`; its exit status, None if it is still there."""
    for number in (PLEASE_END, AT_ONCE):
        try:
            process.send_signal(number)
        except (ProcessLookupError, PermissionError):
            pass
        except (OSError, SystemError):  # Windows': with no console in common there is no Ctrl-Break
            continue
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                return await process.wait()
    return None


def alive(pid: int | None) -> bool:
    """True if a process exists and has not ended, as far as this system lets us check."""
    if pid is None:
        return False
    if WINDOWS:  # signal 0 would end the process there instead of checking it
        return _has_no_exit_code(pid)
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return not _waits_for_its_parent(pid)


def _waits_for_its_parent(pid: int) -> bool:
    """A process that has ended but was not reaped yet still has its number."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return words.rpartition(")")[2].split()[:1] == ["Z"]


def _has_no_exit_code(pid: int) -> bool:
    """Ask Windows; a process that we may not ask about is there."""
    import ctypes

    kernel = getattr(ctypes, "WinDLL")("kernel32", use_last_error=True)  # noqa: B009 - only Windows has it
    kernel.OpenProcess.restype = ctypes.c_void_p
    handle = kernel.OpenProcess(MAY_ASK, False, pid)
    if not handle:
        return getattr(ctypes, "get_last_error")() == ACCESS_DENIED  # noqa: B009
    code = ctypes.c_ulong()
    kernel.GetExitCodeProcess(ctypes.c_void_p(handle), ctypes.byref(code))
    kernel.CloseHandle(ctypes.c_void_p(handle))
    return code.value == STILL_ACTIVE
