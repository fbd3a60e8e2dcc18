"""Signals that ask a process to end, told to its event loop in one way on every system."""

import asyncio
import signal
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

from . import WINDOWS

ENDS = {"SIGINT": "Ctrl-C", "SIGBREAK": "Ctrl-Break", "SIGTERM": "SIGTERM", "SIGHUP": "SIGHUP"}
"""Which of them there are depends on the system; each with the name that a person knows."""

CLOSED, LOGGED_OFF, SHUT_DOWN = 2, 5, 6
"""What Windows tells a console's processes beside Ctrl-C and Ctrl-Break; the last two only services."""
END_S = 30.0
"""Longer than Windows waits for a process that it has told so: some 5 s."""


def on_end(act: Callable[[str], object]) -> Callable[[], None]:
    """Call `act` in the running loop with the name of each signal that asks this process to end.

    A signal that the process was started to ignore stays ignored: so `nohup` keeps its word. Only
    the main thread hears signals. Returns what restores the former handlers.
    """
    loop = asyncio.get_running_loop()
    before: dict[int, Any] = {}
    words: dict[int, str] = {}

    def tell(word: str) -> None:
        if not loop.is_closed():
            loop.call_soon_threadsafe(act, word)

    def hear(number: int, frame: FrameType | None) -> None:
        tell(words[number])

    forget_console = _on_close_of_console(tell) if WINDOWS else None

    def forget() -> None:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        if forget_console is not None:
            forget_console()

    if threading.current_thread() is threading.main_thread():
        for name, word in ENDS.items():
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                words[number] = word
                before[number] = signal.signal(number, hear)
    return forget


_kept: list[Any] = []
"""Handlers that Windows has: it calls them whether Python still knows them or not."""


def _on_close_of_console(tell: Callable[[str], None]) -> Callable[[], None]:
    """Windows ends a process when its handler has returned: this one holds it until it has ended itself.

    Without one, Python hears of the closed window as a Ctrl-Break, and is gone before it can act.
    """
    import ctypes

    kernel = getattr(ctypes, "WinDLL")("kernel32", use_last_error=True)  # noqa: B009 - only Windows has it
    kind = getattr(ctypes, "WINFUNCTYPE", ctypes.CFUNCTYPE)

    def hear(event: int) -> int:
        if event == LOGGED_OFF:  # somebody else: who runs this in a window is not asked
            return 1
        if event not in (CLOSED, SHUT_DOWN):
            return 0  # for `signal`
        tell("the window's end" if event == CLOSED else "the computer's shutdown")
        time.sleep(END_S)
        return 1

    handler = kind(ctypes.c_int, ctypes.c_ulong)(hear)
    _kept.append(handler)
    kernel.SetConsoleCtrlHandler(handler, True)
    return lambda: kernel.SetConsoleCtrlHandler(handler, False)


def until_end() -> asyncio.Event:
    """Set once the process is asked to end."""
    over = asyncio.Event()
    on_end(lambda _: over.set())
    return over
