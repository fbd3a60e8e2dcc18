"""Mouse and keyboard of an X11 desktop, by the RECORD extension: heard, never changed."""

import os
import threading
from typing import Any

from .quiet import have_cookies, quiet_libraries
from .watching import Key, Taker
from .windows import NoScreen

NAMES = {
    0xFF0D: "enter", 0xFF8D: "enter", 0xFF09: "tab", 0xFF1B: "escape", 0xFF08: "backspace",
    0xFFFF: "delete", 0xFF50: "home", 0xFF57: "end", 0xFF51: "left", 0xFF52: "up", 0xFF53: "right",
    0xFF54: "down", 0xFF55: "pageup", 0xFF56: "pagedown",
    **{0xFFBE + n: f"f{n + 1}" for n in range(12)},
}  # fmt: skip
"""Keysym -> the name that the step `press` takes."""
MODIFIERS = range(0xFFE1, 0xFFEF)
UNICODE = 0x01000000


class X11Input:
    """Two connections to the X server: one that is told, one that ends it."""

    def __init__(self) -> None:
        from Xlib import display
        from Xlib.error import DisplayError

        name = os.environ.get("DISPLAY")
        have_cookies()
        try:
            with quiet_libraries():
                self._ours, self._told = display.Display(name), display.Display(name)
        except (DisplayError, OSError) as fault:
            raise NoScreen(f"the screen {name} cannot be opened: {fault}") from fault
        if not self._told.has_extension("RECORD"):
            raise NoScreen(f"the X server of {name} has no RECORD extension, so nothing is heard")
        self._thread: threading.Thread | None = None
        self._context = 0

    def listen(self, take: Taker) -> None:
        from Xlib import X
        from Xlib.ext import record

        nothing = (0, 0)
        self._context = self._told.record_create_context(
            0, [record.AllClients],
            [{
                "core_requests": nothing, "core_replies": nothing, "ext_requests": (0, 0, 0, 0),
                "ext_replies": (0, 0, 0, 0), "delivered_events": nothing, "errors": nothing,
                "device_events": (X.KeyPress, X.ButtonPress), "client_started": False, "client_died": False,
            }],
        )  # fmt: skip

        def hear(reply: Any) -> None:
            self._hear(reply, take)

        self._thread = threading.Thread(
            target=self._told.record_enable_context, args=(self._context, hear), daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        self._ours.record_disable_context(self._context)
        self._ours.flush()
        if self._thread is not None:
            self._thread.join(5)
        self._ours.close()
        self._told.close()

    def _hear(self, reply: Any, take: Taker) -> None:
        from Xlib import X
        from Xlib.protocol import rq

        data: Any = reply.data
        while len(data):
            event, data = rq.EventField("event").parse_binary_value(
                data, self._told.display, None, None
            )
            if event.type == X.ButtonPress and event.detail == 1:
                take.pressed(event.root_x, event.root_y)
            elif event.type == X.KeyPress and (key := self._key(event)) is not None:
                take.typed(key)

    def _key(self, event: Any) -> Key | None:
        from Xlib import X

        shifted = bool(event.state & X.ShiftMask) != bool(event.state & X.LockMask)
        plain = self._ours.keycode_to_keysym(event.detail, 0)
        if plain in MODIFIERS:
            return None
        letter = self._ours.keycode_to_keysym(event.detail, 1 if shifted else 0) or plain
        if not _text(plain).isalpha():  # caps lock changes letters alone
            shifted = bool(event.state & X.ShiftMask)
            letter = self._ours.keycode_to_keysym(event.detail, 1 if shifted else 0) or plain
        with_others = bool(event.state & (X.ControlMask | X.Mod1Mask | X.Mod4Mask))
        if letter in NAMES:
            return Key(name=NAMES[letter], with_others=with_others or shifted)
        return Key(text=_text(letter), with_others=with_others) if _text(letter) else None


def _text(keysym: int) -> str:
    if 0x20 <= keysym <= 0x7E or 0xA0 <= keysym <= 0xFF:
        return chr(keysym)
    return chr(keysym - UNICODE) if keysym >= UNICODE else ""
