"""The desktop of this machine: X11 or Windows."""

import os
import re
import sys

from .controls import Controls
from .watching import Input
from .windows import NoScreen, Windows


def open_windows() -> Windows:
    """The desktop of this machine; raises NoScreen."""
    if sys.platform == "win32":
        from .windows_user32 import User32Windows

        return User32Windows()
    from .windows_x11 import X11Windows

    return X11Windows()


def window_on_screen(title: str) -> str:
    """What one device server at a time may work: the windows so called, on this screen."""
    screen = os.environ.get("DISPLAY") or os.environ.get("SESSIONNAME", "")
    words = f"the window {title!r} on the screen" if title else "the screen"
    return f"{words} {re.sub(r'[.]0$', '', screen)}".rstrip()


def open_input() -> Input:
    """What its mouse and keyboard do; raises NoScreen."""
    if sys.platform == "win32":
        raise NoScreen(
            "mouse and keyboard are heard on X11 only; on Windows record the buttons with `labrun "
            "record-program --buttons`, and write the steps down"
        )
    from .input_x11 import X11Input

    return X11Input()


def open_controls() -> Controls:
    """What tells of a program's controls by name; raises NoScreen."""
    if sys.platform != "win32":
        raise NoScreen(
            "controls are found by name on Windows only (UI Automation); record pictures with `labrun "
            "record-program --buttons`"
        )
    from .controls_uia import UiaControls

    return UiaControls()
