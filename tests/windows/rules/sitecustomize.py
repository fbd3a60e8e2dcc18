"""Windows' rules for files, signals and processes, kept here: what breaks one raises as it would there.

Python imports this file by itself in every process whose PYTHONPATH has its folder. It cannot show
what only the real one does (its console, its drivers, its event loop): it shows what a program
written on another system takes for granted. Rules: Microsoft's "Naming Files, Paths, and Namespaces",
Python's documentation of `os`, `signal` and `asyncio` for Windows.
"""

import asyncio
import asyncio.unix_events
import builtins
import ctypes
import errno
import fcntl
import importlib.util
import io
import os
import re
import signal
import socket
import stat
import struct
import subprocess
import sys
import time
import types
from collections.abc import Callable
from pathlib import Path

POSIX_ONLY = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}
NO_NAME = re.compile(
    r'[<>:"|?*\x00-\x1f\\]|[ .]$|^(CON|PRN|AUX|NUL|COM\d|LPT\d)(\.|$)', re.IGNORECASE
)
CODE_PAGE = "cp1252"
STARTERS = "subprocess", "asyncio"
TICK_S = 1 / 64
"""How fine `time.time` and `time.monotonic` are there, up to Python 3.12."""
LONGEST = 259
"""Characters of a path with its drive, where nobody has enabled longer ones."""
OPEN_RIGHTS = os.O_RDONLY, os.O_WRONLY, os.O_RDWR
BIND_ALL = os.environ.get("LABRUN_WINDOWS_RULES") == "all"
TESTS = () if BIND_ALL else ("labrun.tests.", "labrun.drivers.contract_tests.")
# It writes to the real console; click does without it.
sys.modules.setdefault("colorama", None)  # pyright: ignore[reportArgumentType]
HERE = os.path.dirname(__file__).encode()
ruled: dict[str, bool] = {}
"""Process -> whether it was started under these rules."""
text_mode: set[int] = set()
looks: dict[str, int] = {}
real_open, real_write, real_fsync, real_close = os.open, os.write, os.fsync, os.close
real_import, real_popen, real_kill = builtins.__import__, subprocess.Popen.__init__, os.kill


def of_labrun(module: object) -> bool:
    name = str(module)
    if BIND_ALL and name.startswith("tests."):  # as pytest may call them
        return True
    return (name == "labrun" or name.startswith("labrun.")) and not name.startswith(TESTS)


def is_ours(depth: int = 2) -> bool:
    """Whether labrun itself calls, rather than a test, or a library that has its own way on Windows."""
    return of_labrun(sys._getframe(depth).f_globals.get("__name__"))


def asker_is_ours(*through: str) -> bool:
    """The same of whoever asks through these modules of Python."""
    frame = sys._getframe(2)
    while str(frame.f_globals.get("__name__", "")).startswith(through):
        if frame.f_back is None:
            return True  # a task: only labrun's are started from one
        frame = frame.f_back
    return of_labrun(frame.f_globals.get("__name__"))


class Shy(types.ModuleType):
    """A module without what Windows lacks, as labrun sees it; what tests do to it needs more."""

    def __getattr__(self, name: str) -> object:
        gone = shy.get(self.__name__, {})
        if name not in gone or is_ours():
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        return gone[name]


shy: dict[str, dict[str, object]] = {}


def take(module: types.ModuleType, *names: str) -> None:
    """Take from a module what it lacks on Windows."""
    shy[module.__name__] = {name: getattr(module, name) for name in names if hasattr(module, name)}
    for name in shy[module.__name__]:
        delattr(module, name)
    module.__class__ = Shy


def refused(path: object, why: int = errno.EACCES) -> OSError:
    return OSError(why, os.strerror(why), str(path))


def check_name(path: object) -> None:
    name = os.fspath(path) if isinstance(path, (str, os.PathLike)) else ""
    name = name.decode() if isinstance(name, bytes) else name
    if len(os.path.abspath(name)) > LONGEST:
        raise refused(path, errno.ENOENT)
    for part in Path(name).parts:
        if part != os.sep and part not in (".", "..") and NO_NAME.search(part):
            raise refused(path, errno.EINVAL)


def is_open(path: object) -> bool:
    """Whether this process has a file open, which nobody may then replace, rename or delete."""
    try:
        there = os.lstat(path)  # type: ignore[arg-type]
    except OSError:
        return False
    for number in () if stat.S_ISDIR(there.st_mode) else os.listdir("/proc/self/fd"):
        try:
            held = os.stat(int(number))
        except OSError:
            continue
        if (held.st_dev, held.st_ino) == (there.st_dev, there.st_ino):
            return True
    return False


def is_open_elsewhere(path: object) -> bool:
    """The same of other processes under these rules."""
    place = os.path.realpath(path)  # type: ignore[arg-type]
    for pid in (
        ()
        if os.path.isdir(place) or os.path.islink(path)
        else filter(str.isdigit, os.listdir("/proc"))
    ):
        try:
            if pid not in ruled:
                ruled[pid] = HERE in Path(f"/proc/{pid}/environ").read_bytes()
            numbers = os.listdir(f"/proc/{pid}/fd") if ruled[pid] else []
        except OSError:
            continue
        for number in numbers:
            try:
                if os.readlink(f"/proc/{pid}/fd/{number}") == place:
                    return True
            except OSError:
                continue
    return False


def open_(path, flags, mode=0o777, *, dir_fd=None):
    if not is_ours():
        return real_open(path, flags, mode, dir_fd=dir_fd)
    check_name(path)
    if os.path.isdir(path):
        raise refused(path)
    descriptor = real_open(path, flags & ~os.O_BINARY, mode)
    if not flags & os.O_BINARY:
        text_mode.add(descriptor)
    return descriptor


def write(descriptor, data):
    if descriptor not in text_mode:
        return real_write(descriptor, data)
    real_write(descriptor, bytes(data).replace(b"\n", b"\r\n"))
    return len(data)


def close(descriptor):
    text_mode.discard(descriptor)
    real_close(descriptor)


def fsync(descriptor):
    if fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))
    real_fsync(descriptor)


def scanned(path: object) -> bool:
    """Whether a virus scanner holds a file: it looks at each new one, for as long as two attempts take."""
    looks[str(path)] = looks.get(str(path), 0) + 1
    return looks[str(path)] <= 2


def guarded(name: str, *, both: bool):
    """Renaming, replacing and deleting: not of what is open, nor onto it."""
    real = getattr(os, name)

    def act(path, *others, **named):
        ours = is_ours() or is_ours(3)
        if ours and os.path.exists(path) and scanned(path):
            raise PermissionError(errno.EACCES, "a virus scanner looks at it", str(path))
        targets = [path, *others[:1]] if both else [path]
        for target in targets:
            check_name(target)
            if is_open(target) or (ours and is_open_elsewhere(target)):
                raise PermissionError(
                    errno.EACCES, "it is being used by another process", str(target)
                )
        if name == "rename" and os.path.exists(others[0]):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(others[0]))
        return real(path, *others, **named)

    return act


def mkdir_(path, *more, **named):
    check_name(path)
    if len(os.path.abspath(path)) > LONGEST - 12:  # there must be room for a file in it
        raise refused(path, errno.ENOENT)
    return real_mkdir(path, *more, **named)


def builtin_open(
    file, mode="r", buffering=-1, encoding=None, errors=None, newline=None, *more, **named
):
    if not isinstance(file, int):
        check_name(file)
    if "b" not in mode and asker_is_ours("pathlib", "tempfile"):
        encoding = CODE_PAGE if encoding in (None, "locale") else encoding
        newline = "\r\n" if newline is None and not mode.startswith("r") else newline
    return real_builtin_open(file, mode, buffering, encoding, errors, newline, *more, **named)


def text_encoding(encoding, stacklevel=2):
    """What `pathlib` opens a text with; `locale` is the code page."""
    if encoding is None and asker_is_ours("pathlib"):
        return "locale"
    return real_text_encoding(encoding, stacklevel)


class Stepped:
    """A clock that goes on by TICK_S, as those of Windows do; like them no method, wherever it is kept."""

    def __init__(self, real: Callable[[], float]) -> None:
        self.real = real

    def __call__(self) -> float:
        return self.real() // TICK_S * TICK_S


def clock_info(name: str) -> types.SimpleNamespace:
    found = real_clock_info(name)
    if name in ("monotonic", "time"):
        found.resolution = TICK_S
    return found


def import_(name, globals=None, locals=None, fromlist=(), level=0):
    if not level and name in POSIX_ONLY and of_labrun((globals or {}).get("__name__")):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return real_import(name, globals, locals, fromlist, level)


def popen(self, *more, **named):
    if (named.get("start_new_session") or named.get("preexec_fn")) and asker_is_ours(*STARTERS):
        raise ValueError("Windows has no sessions: start_new_session is for other systems")
    if named.pop("creationflags", 0) & subprocess.CREATE_NEW_PROCESS_GROUP:
        named["start_new_session"] = True
    if (named.get("text") or named.get("universal_newlines")) and asker_is_ours(*STARTERS):
        named["encoding"] = named.get("encoding") or CODE_PAGE
    real_popen(self, *more, **named)


def kill(pid, number):
    # There every number but those of the console ends the process at once.
    at_once = (is_ours() or asker_is_ours(*STARTERS)) and number != signal.CTRL_BREAK_EVENT
    real_kill(pid, KILL if at_once else number)


def ends(self):
    """`terminate` and `kill` are one there."""
    if self.returncode is None:
        real_kill(self.pid, KILL if asker_is_ours(*STARTERS) else signal.SIGTERM)


def bind(self, address):
    # A port whose last connections have just been closed is free at once there.
    self.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    super(socket.socket, self).bind(address)


def unknown(name: str) -> Callable[..., object]:
    """What a loop cannot do there."""
    real = getattr(loops, name)

    def act(self, *more):
        if is_ours():
            raise NotImplementedError
        return real(self, *more)

    return act


def locking(descriptor: int, mode: int, count: int) -> None:
    """As msvcrt's: the bytes from the descriptor's place on; nobody else may even read them."""
    # Of this opening of the file, as there: a second one in the same process is refused, too.
    wanted = struct.pack("hhqqi4x", fcntl.F_WRLCK, os.SEEK_CUR, 0, count, 0)
    fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, wanted)


console_handlers: list[Callable[[int], int]] = []


class Kernel32:
    """What is asked of it: whether a process has an exit code, and who hears of the console's end."""

    def __init__(self, name: str, *, use_last_error: bool) -> None:
        self.OpenProcess = self.Opened()

    class Opened:
        """A function with attributes, as ctypes makes them."""

        def __call__(self, rights: int, inherited: bool, pid: int) -> int:
            try:
                real_kill(pid, 0)
                state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
            except OSError:
                return 0
            return 0 if state == "Z" else pid

    def GetExitCodeProcess(self, handle: ctypes.c_void_p, code: object) -> None:  # noqa: N802
        code._obj.value = 259  # type: ignore[attr-defined]

    def SetConsoleCtrlHandler(self, handler: Callable[[int], int], added: bool) -> None:  # noqa: N802
        console_handlers.insert(0, handler) if added else console_handlers.remove(handler)

    def CloseHandle(self, handle: ctypes.c_void_p) -> None:  # noqa: N802
        """Nothing is held."""


KILL = signal.SIGKILL
ctypes.WinDLL, ctypes.get_last_error = Kernel32, lambda: 0  # type: ignore[attr-defined]
real_mkdir, real_builtin_open, real_clock_info = os.mkdir, builtins.open, time.get_clock_info
real_text_encoding = io.text_encoding
os.O_BINARY = 1 << 30  # type: ignore[attr-defined]
os.open, os.write, os.close, os.fsync, os.mkdir = open_, write, close, fsync, mkdir_  # type: ignore[assignment]
builtins.open = io.open = builtin_open
io.text_encoding = text_encoding  # type: ignore[assignment]
time.time, time.monotonic, time.get_clock_info = (
    Stepped(time.time),
    Stepped(time.monotonic),
    clock_info,
)  # type: ignore[assignment]
os.replace, os.rename = guarded("replace", both=True), guarded("rename", both=True)
os.unlink, os.remove = guarded("unlink", both=False), guarded("remove", both=False)
os.kill = kill
signal.SIGBREAK = signal.CTRL_BREAK_EVENT = signal.SIGUSR1  # type: ignore[attr-defined]
take(
    os, "fdatasync", "killpg", "mkfifo", "sched_getaffinity", "getuid", "geteuid", "fork", "setsid"
)
take(signal, "SIGHUP", "SIGKILL", "SIGSTOP", "SIGCONT", "SIGUSR2", "SIGALRM")
subprocess.CREATE_NEW_PROCESS_GROUP = 0x200  # type: ignore[attr-defined]
subprocess.Popen.__init__ = popen  # type: ignore[method-assign]
subprocess.Popen.terminate = ends  # type: ignore[method-assign]
socket.socket.bind = bind  # type: ignore[method-assign]
loops = asyncio.unix_events._UnixSelectorEventLoop
for name in ("add_signal_handler", "add_reader", "add_writer"):
    setattr(loops, name, unknown(name))
msvcrt = types.ModuleType("msvcrt")
msvcrt.locking, msvcrt.LK_NBLCK = locking, 2  # type: ignore[attr-defined]
sys.modules["msvcrt"] = msvcrt
builtins.__import__ = import_
if importlib.util.find_spec("labrun") is not None:
    import labrun.system

    labrun.system.WINDOWS = True
