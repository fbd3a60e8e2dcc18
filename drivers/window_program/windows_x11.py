"""Windows of an X11 desktop, with or without a window manager."""

import os
import select
import time
from typing import Any

from .quiet import have_cookies, quiet_libraries
from .windows import NoScreen, Window

MANY = 200
FIRST_PING_S = 0.5


class X11Windows:
    """One connection to the X server, used by one thread at a time."""

    def __init__(self) -> None:
        from Xlib import X, display
        from Xlib.error import DisplayError

        name = os.environ.get("DISPLAY")
        if not name:
            raise NoScreen(
                "there is no screen: DISPLAY is not set; start the device server on the analyser's "
                "own desktop"
            )
        have_cookies()
        try:
            with quiet_libraries():
                self._display = display.Display(name)
        except (DisplayError, OSError) as fault:
            raise NoScreen(f"the screen {name} cannot be opened: {fault}") from fault
        self._root = self._display.screen().root
        self._root.change_attributes(event_mask=X.SubstructureNotifyMask)
        self._pings = 0
        self._answered: set[int] = set()

    def close(self) -> None:
        self._display.close()

    def listed(self) -> list[Window]:
        found = []
        for child in reversed(self._root.query_tree().children):
            window = self._seen(child)
            if window is not None:
                found.append(window)
        return found

    def _seen(self, frame: Any) -> Window | None:
        """A child of the root: a program's own window, or a frame that a window manager put round it."""
        from Xlib import X
        from Xlib.error import XError

        try:
            if frame.get_attributes().map_state != X.IsViewable:
                return None
            client = self._client(frame)
            shape = client.get_geometry()
            corner = client.translate_coords(self._root, 0, 0)
            owned = client.get_wm_transient_for() is not None
            popup = bool(client.get_attributes().override_redirect)
            title = self._title(client)
        except XError:  # it went away while we looked
            return None
        box = (-corner.x, -corner.y, shape.width, shape.height)
        program = client.id & ~self._display.display.info.resource_id_mask
        return Window(frame.id, title, box, owned, popup, program)

    def _client(self, window: Any, depth: int = 3) -> Any:
        """The window with a title at or below this one; itself where there is none."""
        if window.get_wm_name() or window.get_wm_class() or not depth:
            return window
        for child in window.query_tree().children[:MANY]:
            found = self._client(child, depth - 1)
            if found.get_wm_name():
                return found
        return window

    def _title(self, client: Any) -> str:
        utf8 = self._display.intern_atom("UTF8_STRING")
        long = client.get_full_property(self._display.intern_atom("_NET_WM_NAME"), utf8)
        if long is not None and isinstance(long.value, bytes):
            return long.value.decode("utf-8", "replace")
        name = client.get_wm_name() or ""
        return name if isinstance(name, str) else name.decode("latin-1")

    def alive(self, window: Window, timeout_s: float) -> bool | None:
        """Asked by _NET_WM_PING; a program sends it back when it has done all that came before.

        Silence says something only of a program that promises to answer, or has answered before.
        """
        from Xlib import X
        from Xlib.error import XError
        from Xlib.protocol import event

        ping = self._display.intern_atom("_NET_WM_PING")
        try:
            client = self._client(self._display.create_resource_object("window", window.id))
            promised = ping in (client.get_wm_protocols() or [])
            self._pings += 1
            asked = event.ClientMessage(
                window=client, client_type=self._display.intern_atom("WM_PROTOCOLS"),
                data=(32, [ping, self._pings, client.id, 0, 0]),
            )  # fmt: skip
            client.send_event(asked, event_mask=X.NoEventMask)
            self._display.flush()
        except XError:
            return None
        sure = promised or client.id in self._answered
        if self._pong(ping, client.id, timeout_s if sure else min(timeout_s, FIRST_PING_S)):
            self._answered.add(client.id)
            return True
        return False if sure else None

    def _pong(self, ping: int, client: int, timeout_s: float) -> bool:
        end = time.monotonic() + timeout_s
        while True:
            while self._display.pending_events():
                told = self._display.next_event()
                data = getattr(told, "data", None)
                if data and list(data[1])[:3] == [ping, self._pings, client]:
                    return True
            left = end - time.monotonic()
            if left <= 0:
                return False
            select.select([self._display.fileno()], [], [], left)

    def at(self, x: int, y: int) -> int | None:
        from Xlib import X

        below = self._root.translate_coords(self._root, x, y).child
        return None if below == X.NONE else below.id
