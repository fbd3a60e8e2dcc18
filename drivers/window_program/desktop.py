"""The desktop of this machine: X11 or Windows."""

import sys

from .windows import Windows


def open_windows() -> Windows:
    """The desktop of this machine; raises NoScreen."""
    if sys.platform == "win32":
        from .windows_user32 import User32Windows

        return User32Windows()
    from .windows_x11 import X11Windows

    return X11Windows()
