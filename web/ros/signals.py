"""Ctrl-C and SIGTERM as an event."""

import asyncio
import signal
import sys


def until_signal() -> asyncio.Event:
    """Set when the process is asked to end."""
    over = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        if sys.platform == "win32":
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(over.set))
        else:
            loop.add_signal_handler(number, over.set)
    return over
