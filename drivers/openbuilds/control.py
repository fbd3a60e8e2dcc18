"""Talk to OpenBuilds CONTROL: its events, its queue, and the only proof that a line is done.

CONTROL acknowledges nothing, reports Idle too early and `jobComplete` when everything is sent. But
each line that the controller has answered comes back as an event `ok` with its exact text: so every
command ends with its own `G4 P0 (tag)`, which the controller answers when all motion has ended.
"""

import asyncio
import contextlib
import logging
import re
from typing import TYPE_CHECKING, Any

from ...system.tasks import end
from ..grbl.faults import Alarmed, GrblRefused, reset_in_homing
from ..grbl.firmware import Firmware, firmware_of
from ..motion.faults import Lost, MotionFault, NotConnected, Restarted, Silent
from ..serial_io.condition import Condition
from .proofs import Proofs
from .view import ALARM, CONNECTED, NONE, OPENING, View, read_view

if TYPE_CHECKING:
    import aiohttp
    import socketio

CONNECT_S = 20
CLOSE_S = 3.0
SETTLE_S = 1.0
REPORT_S = 2.0
PENDING, RUNNING = "Pending", "Running"
"""Its own words in place of a controller's state: before the first report, and after any command."""
LOCKED = 9
SETTING = re.compile(r"^\$(\d+)=(\S+)")
PROBED = re.compile(r"\[PRB:(.*)\]")
LOG = logging.getLogger("labrun")
BANNER = re.compile(r"Grbl(?:HAL)? \d")
RESET_S = 3.0
"""A boot within this time after CONTROL was asked for a reset is the one that was asked for."""
UNNAMED_S = 0.3
AGAIN_S = 0.3
"""Opening a port may boot a board twice: by the port, and by CONTROL's own reset."""
RESTARTED = (
    "it restarted unexpectedly (reset button, emergency stop, or power failure); "
    "its position is unknown. Home it"
)


class Control:
    """One CONTROL and the controller behind it, as currently known.

    `homed` and `alarm` are as for a GRBL controller on a serial port; `lost` is the reason why no
    command can be sent.
    """

    def __init__(self, url: str, port: dict[str, Any], silence_s: float, boot_s: float) -> None:
        self.url = url
        self.port = port
        self._silence_s = silence_s
        self._boot_s = boot_s
        self.view: View | None = None
        self.heard_at = 0.0
        self.homed = False
        self.alarm = ""
        self.alarm_at = 0.0
        self._settled_at = 0.0
        self.boots = 0
        self._reset_until = 0.0
        self._starting = False
        self.probed: list[str] = []
        self.settings: dict[str, str] = {}
        self.configuration = ""
        self.banner = ""
        self.disconnected = "it has not been connected yet"
        self._http: aiohttp.ClientSession | None = None
        self._sio: socketio.AsyncClient | None = None
        self.proofs = Proofs()
        self._condition = Condition()
        self.until = self._condition.until

    async def open(self) -> None:
        """Connect to CONTROL; raises OSError with the reason."""
        import aiohttp
        import socketio
        from socketio.exceptions import ConnectionError as NoConnection

        self._http = aiohttp.ClientSession()
        sio = self._sio = socketio.AsyncClient(
            reconnection_delay=1,
            reconnection_delay_max=2,
            handle_sigint=False,
            http_session=self._http,
        )
        for event, take in (
            ("connect", self._connected), ("disconnect", self._gone), ("status", self._status),
            ("ok", self._ok), ("data", self._data), ("toastError", self._error),
            ("toastErrorAlarm", self._alarm), ("fluidncConfig", self._configured),
        ):  # fmt: skip
            sio.on(event, take)
        try:
            await sio.connect(self.url, transports=["websocket"], wait_timeout=CONNECT_S)
        except (NoConnection, OSError, ValueError) as fault:
            await self.close()
            raise OSError(
                f"OpenBuilds CONTROL does not respond at {self.url} ({fault}); start the program, and "
                f"check its address there (it uses port 3000, else 3020, 3200 or 3220)"
            ) from fault
        if not await self.until(lambda: self.view is not None, CONNECT_S):
            await self.close()
            raise OSError(f"{self.url} responds, but not as OpenBuilds CONTROL does: no `status`")

    async def close(self) -> None:
        """Disconnect; CONTROL keeps its port."""
        if self._sio is not None:
            sio, self._sio = self._sio, None
            self.proofs.fail(Lost("it was closed"))
            try:
                with contextlib.suppress(TimeoutError, OSError):  # it need not close cleanly
                    async with asyncio.timeout(CLOSE_S):
                        await sio.shutdown()
            except Exception:  # whatever it was, its tasks and its socket have to go
                LOG.exception("closing the connection to %s failed", self.url)
            await end(sio.eio.read_loop_task, sio.eio.write_loop_task)
        if self._http is not None:
            http, self._http = self._http, None
            await http.close()

    @property
    def lost(self) -> str:
        """Why no command can be sent; empty if one can."""
        if self.disconnected:
            return f"{self.url}: {self.disconnected}"
        if self.silent_s() > self._silence_s:
            return f"{self.url} has sent no status for {self.silent_s():.0f} s"
        if self.view is None or self.view.connection in (NONE, OPENING):
            return f"OpenBuilds CONTROL at {self.url} has no port open; is the cable plugged in?"
        if self._pending():
            return f"OpenBuilds CONTROL at {self.url} has had no report of {self._port_name()} yet"
        return ""

    @property
    def kind(self) -> Firmware:
        """Which firmware it is, by its banner or as CONTROL calls it: GRBL, until either is known."""
        return firmware_of(self.banner or (self.view.firmware if self.view else ""))

    def unsettle(self) -> None:
        """Note that something has moved: the reported position may be up to 0.9 s old."""
        self._settled_at = asyncio.get_running_loop().time() + SETTLE_S

    async def view_at_rest(self) -> View:
        """The view once it certainly includes the last motion; raises Lost.

        `Running` is CONTROL's own state after a command; the controller's next report replaces it.
        """
        await asyncio.sleep(max(0.0, self._settled_at - asyncio.get_running_loop().time()))
        await self.until(lambda: bool(self.lost) or self.look().run != RUNNING, REPORT_S)
        return self.look()

    def silent_s(self) -> float:
        """Seconds since CONTROL's last status."""
        return asyncio.get_running_loop().time() - self.heard_at

    def look(self) -> View:
        """The newest view; raises Lost."""
        if self.lost or self.view is None:
            raise Lost(self.lost)
        return self.view

    async def attach(self) -> None:
        """Make CONTROL open our port if it has none open; raises OSError. Opening boots the controller.

        CONTROL closes it again if it has heard no banner after 2 s.
        """
        view = self.view
        if view is not None and view.connection not in (NONE, OPENING):
            if self._is_ours(view):
                return
            raise OSError(
                f"OpenBuilds CONTROL at {self.url} has {view.active_port} open, not "
                f"{self._port_name()}; disconnect it there, or correct `port` in the lab"
            )
        before = self.boots
        if view is None or view.connection == NONE:
            self._asks_reset()
            await self.emit("connectTo", self.port)
        if not await self.until(self._port_open, self._boot_s):
            raise OSError(
                f"OpenBuilds CONTROL at {self.url} did not open {self._port_name()} within "
                f"{self._boot_s:g} s; is the cable plugged in, and the port name right?"
            )
        # The port counts as connected while the board still boots, and loses what it is sent.
        await self.until(lambda: self.boots > before or not self._port_open(), self._boot_s)
        self._check_still_open()

    async def first_report(self) -> None:
        """Wait for the first report since CONTROL was started; raises OSError if none comes.

        It comes two seconds after the port was opened. Where it tells of a reset button, CONTROL stops
        the board: `!`, and a reset 0.2 s later. A command before it would put `Running` in its place.
        """
        self._starting = True
        try:
            heard = await self.until(
                lambda: not self._pending() or not self._port_open(), self._boot_s
            )
            self._check_still_open()  # its two seconds may be over as the banner comes
            if not heard:
                raise OSError(
                    f"OpenBuilds CONTROL at {self.url} has had no report of {self._port_name()} within "
                    f"{self._boot_s:g} s; look for `<Idle|...>` in its console, and switch the "
                    f"controller off and on; for one that is slow: `boot_s: {2 * self._boot_s:g}`"
                )
            before = self.boots
            if self.view is not None and "R" in self.view.pins:
                await self.until(lambda: self.boots > before, RESET_S)
        finally:
            self._starting = False

    def _check_still_open(self) -> None:
        if not self._port_open():
            raise OSError(
                f"OpenBuilds CONTROL at {self.url} has closed {self._port_name()} again: nothing on it "
                f"responded in time; is the controller switched on, and is this its port? A board that "
                f"takes more than 1.5 s to boot is too slow for it"
            )

    def _pending(self) -> bool:
        return self.view is not None and self.view.run == PENDING

    def _port_open(self) -> bool:
        return self.view is not None and self.view.connection not in (NONE, OPENING)

    def _is_ours(self, view: View) -> bool:
        return not view.active_port or view.active_port == self._port_name()

    def _port_name(self) -> str:
        return str(self.port.get("port") or self.port.get("ip"))

    async def emit(self, event: str, data: Any) -> None:
        """Send an event to CONTROL; raises NotConnected if there is no connection."""
        if self._sio is None or not self._sio.connected:
            raise NotConnected(f"{self.url}: {self.disconnected or 'there is no connection'}")
        if event in ("stop", "clearAlarm"):
            self._asks_reset()
        await self._sio.emit(event, data)

    def _asks_reset(self) -> None:
        self._reset_until = asyncio.get_running_loop().time() + RESET_S

    async def run(self, *lines: str) -> asyncio.Future[None]:
        """Queue lines and a proof; the future ends when the controller has executed them all."""
        if self.lost:
            raise NotConnected(self.lost)
        proof = self.proofs.next_line()
        answer = self.proofs.expect(proof)
        await self.emit("runCommand", "\n".join([*lines, proof]))
        return answer

    async def ask(self, line: str, seconds: float) -> None:
        """Queue one line and wait for its `ok`."""
        answer = self.proofs.expect(line)
        await self.emit("runCommand", line)
        await asyncio.wait({answer}, timeout=seconds)
        if not answer.done():
            self.proofs.forget(line)
            raise Silent(f"it did not respond to `{line}` within {seconds:g} s")
        answer.result()

    async def drop(self, *, abort: bool = False, jog: bool = False) -> None:
        """CONTROL's own stop: its queue is dropped and the controller reset (or the jog ended)."""
        await self.emit("stop", {"stop": not jog, "jog": jog, "abort": abort})

    def _connected(self) -> None:
        self.disconnected = ""
        self.heard_at = asyncio.get_running_loop().time()
        self._condition.set()

    def _gone(self, *_: Any) -> None:
        self.disconnected = "the connection to OpenBuilds CONTROL was lost; is the program running?"
        self._not_trusted(f"{self.disconnected} Home it")
        self.view = None  # the next one may be from a restarted program
        self.proofs.fail(Lost(self.disconnected))
        self._condition.set()

    def _status(self, data: Any) -> None:
        view, before = read_view(data), self.view
        if view is None:
            return
        self.heard_at = asyncio.get_running_loop().time()
        self.view = view
        if view.connection == ALARM and (before is None or before.connection != ALARM):
            # The toast that names it comes at about the same time, or never (alarm 5).
            asyncio.get_running_loop().call_later(UNNAMED_S, self._unnamed)
        if view.connection == NONE and before is not None and before.connection != NONE:
            self._not_trusted("the port was lost (unplugged?). Home it when it is back")
            self.proofs.fail(Lost("OpenBuilds CONTROL lost the port; is the cable plugged in?"))
        self._condition.set()

    def _unnamed(self) -> None:
        """An error or alarm shown by `connectionStatus` alone; a board locked since its boot has none."""
        if self._sio is not None and self.view is not None and self.view.run in (PENDING, RUNNING):
            # Before the first report, and after a command until the next, nothing is known of the board.
            asyncio.get_running_loop().call_later(UNNAMED_S, self._unnamed)
        elif self.view is not None and self.view.connection == ALARM and not self.alarm:
            unhomed = "" if self.kind.unhomed is None else str(self.kind.unhomed)
            if self.view.run == "Alarm" and self.view.alarm.partition(" ")[0] in ("", unhomed):
                self.homed = False
                return
            said = self.view.alarm.rstrip(".") or "it did not report which"
            self._not_trusted(f"OpenBuilds CONTROL reports an error or alarm: {said}. Unlock it")
            self.proofs.fail(MotionFault(f"OpenBuilds CONTROL reports an error or alarm ({said})"))
            self._condition.set()

    def _ok(self, line: Any = "") -> None:
        self.proofs.answered(str(line))
        self._note_setting(str(line))  # as some program has set it
        self._condition.set()

    def _data(self, data: Any = None) -> None:
        said = str(data.get("response", "")) if isinstance(data, dict) else str(data)
        for line in said.splitlines():
            self._note_setting(line.strip())
            if found := PROBED.search(line):
                self.probed.append(found[1])
            if BANNER.search(line):
                self.banner = line
                self._booted()
        self._condition.set()

    def _note_setting(self, line: str) -> None:
        if found := SETTING.match(line):
            self.settings[found[1]] = found[2]

    def _booted(self) -> None:
        self.boots += 1
        now = asyncio.get_running_loop().time()
        if self._starting or now <= self._reset_until:
            self._reset_until = now + AGAIN_S
        else:
            self._not_trusted(self.alarm or RESTARTED)
            self.proofs.fail(Restarted(RESTARTED))

    def _error(self, text: Any = "") -> None:
        code = _number(text)
        # CONTROL's queue is halted from here on, until it is cleared.
        if code != LOCKED or not self.alarm.startswith("ALARM:"):  # which it only follows from
            self.alarm = f"{self.kind.error(code)}; its queue is halted. Unlock it"
        self.proofs.fail(GrblRefused(code, self.kind))
        self._condition.set()

    def _alarm(self, text: Any = "") -> None:
        code = _number(text)
        if asyncio.get_running_loop().time() <= self._reset_until:
            code = reset_in_homing(code)
        if code == self.kind.unhomed:
            self.homed = False
            return
        self._not_trusted(self.kind.alarm(code))
        self.proofs.fail(Alarmed(code, self.kind))
        self._condition.set()

    def _configured(self, text: Any = "") -> None:
        self.configuration = str(text)
        self._condition.set()

    def _not_trusted(self, why: str) -> None:
        self.homed, self.alarm = False, why
        self.alarm_at = asyncio.get_running_loop().time()

    @property
    def locked(self) -> bool:
        """Whether no line is accepted until it is homed or unlocked."""
        view = self.view
        return view is not None and (view.run == "Alarm" or view.connection == ALARM)

    @property
    def clear(self) -> bool:
        """Whether lines are accepted again."""
        return self.view is not None and self.view.connection == CONNECTED and not self.locked


def _number(text: Any) -> int:
    found = re.search(r"(?:error|ALARM):\s*(\d+)", str(text))
    return int(found[1]) if found else 0
