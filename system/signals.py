"""Signals that ask a process to end, told to its event loop in one way on every system."""

import asyncio
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

ENDS = {"SIGINT": "Ctrl-C", "SIGBREAK": "Ctrl-Break", "SIGTERM": "SIGTERM", "SIGHUP": "SIGHUP"}
"""Which of them there are depends on the system; each with the name that a person knows."""


def on_end(act: Callable[[str], object]) -> Callable[[], None]:
    """Call `act` in the running loop with the name of each signal that asks this process to end.

    A signal that the process was started to ignore stays ignored: so `nohup` keeps its word. Only
    the main thread hears signals. Returns what restores the former handlers.
    """
    loop = asyncio.get_running_loop()
    before: dict[int, Any] = {}
    words: dict[int, str] = {}

    def hear(number: int, frame: FrameType | None) -> None:
        if not loop.is_closed():
            loop.call_soon_threadsafe(act, words[number])

    def forget() -> None:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)

    if threading.current_thread() is threading.main_thread():
        for name, word in ENDS.items():
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                words[number] = word
                before[number] = signal.signal(number, hear)
    return forget


def until_end() -> asyncio.Event:
    """Set once the process is asked to end."""
    over = asyncio.Event()
    on_end(lambda _: over.set())
    return over
