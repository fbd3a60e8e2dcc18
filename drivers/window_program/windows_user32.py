"""Windows of a Windows desktop, by user32."""

import ctypes
import time
from ctypes import byref, c_long, c_void_p, create_unicode_buffer
from typing import Any

from .windows import NoScreen, Window

GW_OWNER, GA_ROOT = 4, 2
DWMWA_CLOAKED = 14
LONGEST_TITLE = 512
GWL_STYLE, WS_POPUP, WS_CAPTION = -16, 0x80000000, 0x00C00000


class _Rect(ctypes.Structure):
    _fields_ = [(side, c_long) for side in ("left", "top", "right", "bottom")]


class _Point(ctypes.Structure):
    _fields_ = [("x", c_long), ("y", c_long)]


class User32Windows:
    """EnumWindows lists windows from top to bottom; IsHungAppWindow detects a hung program."""

    def __init__(self) -> None:
        loaded: Any = ctypes
        self._user32 = loaded.windll.user32
        self._dwm = loaded.windll.dwmapi
        self._callback = loaded.WINFUNCTYPE(ctypes.c_bool, c_void_p, c_void_p)
        self._user32.WindowFromPoint.argtypes = [_Point]
        for name in ("WindowFromPoint", "GetAncestor", "GetWindow", "OpenInputDesktop"):
            getattr(self._user32, name).restype = c_void_p

    def close(self) -> None:
        """Nothing to release."""

    def listed(self) -> list[Window]:
        desktop = self._user32.OpenInputDesktop(0, False, 0x0100)
        if not desktop:
            raise NoScreen("the screen is locked: this session's desktop accepts no input")
        self._user32.CloseDesktop(c_void_p(desktop))
        found: list[Window] = []

        def note(handle: int, _: int) -> bool:
            window = self._seen(handle)
            if window is not None:
                found.append(window)
            return True

        self._user32.EnumWindows(self._callback(note), 0)
        return found

    def _seen(self, number: int) -> Window | None:
        handle = c_void_p(number)
        if not self._user32.IsWindowVisible(handle) or self._user32.IsIconic(handle):
            return None
        cloaked = c_long(0)
        self._dwm.DwmGetWindowAttribute(handle, DWMWA_CLOAKED, byref(cloaked), 4)
        rect, title = _Rect(), create_unicode_buffer(LONGEST_TITLE)
        self._user32.GetWindowRect(handle, byref(rect))
        self._user32.GetWindowTextW(handle, title, LONGEST_TITLE)
        width, height = rect.right - rect.left, rect.bottom - rect.top
        if cloaked.value or width <= 0 or height <= 0:
            return None
        owned = bool(self._user32.GetWindow(handle, GW_OWNER))
        style = self._user32.GetWindowLongW(handle, GWL_STYLE) & 0xFFFFFFFF
        popup = bool(style & WS_POPUP) and style & WS_CAPTION != WS_CAPTION
        program = c_long(0)
        self._user32.GetWindowThreadProcessId(handle, byref(program))
        box = (rect.left, rect.top, width, height)
        return Window(number, title.value, box, owned, popup, program.value)

    def alive(self, window: Window, timeout_s: float) -> bool | None:
        """Windows calls a program hung when it has fetched no message for 5 s; it is asked sooner."""
        answered = c_long(0)
        handle, nothing = c_void_p(window.id), c_void_p(0)
        end = time.monotonic() + timeout_s
        while True:
            # WM_NULL with SMTO_ABORTIFHUNG: it comes back when the program has fetched it.
            if self._user32.SendMessageTimeoutW(
                handle, 0, nothing, nothing, 2, 200, byref(answered)
            ):
                return True
            if time.monotonic() > end:
                return False

    def at(self, x: int, y: int) -> int | None:
        found = self._user32.WindowFromPoint(_Point(x, y))
        return self._user32.GetAncestor(c_void_p(found), GA_ROOT) if found else None
