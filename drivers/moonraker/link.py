"""Talk to Moonraker: JSON-RPC over its WebSocket, and what Klipper behind it reports of itself."""

import asyncio
import contextlib
import itertools
import json
from typing import TYPE_CHECKING, Any

from ...system.tasks import end, spawn
from ..motion.faults import Lost, MotionFault, NotConnected, NotThere, Refused, Silent
from ..serial_io.condition import Condition

if TYPE_CHECKING:
    import aiohttp

CONNECT_S = 10.0
ANSWER_S = 10.0
WATCHED = {
    "toolhead": [
        "position",
        "homed_axes",
        "axis_minimum",
        "axis_maximum",
        "max_velocity",
        "max_accel",
    ],
    "gcode_move": ["position", "gcode_position", "speed_factor"],
    "motion_report": ["live_position", "live_velocity"],
    "webhooks": ["state", "state_message"],
    "virtual_sdcard": ["is_active", "file_path"],
}
REFUSALS = {"Must home axis first": "NotHomed", "Move out of range": "SoftLimit"}
"""The contract's names for how Klipper refuses a move."""

NOT_READY = {"notify_klippy_disconnected": "disconnected", "notify_klippy_shutdown": "shutdown"}


class Link:
    """One Moonraker, and Klipper behind it, as currently known.

    `status` is what Klipper reports: object -> field -> value. `lost` is the reason why nothing can
    be sent, `alarm` why Klipper accepts no motion; empty if there is none.
    """

    def __init__(self, url: str, api_key: str | None) -> None:
        self.url = url
        self.api_key = api_key
        self.status: dict[str, dict[str, Any]] = {}
        self.disconnected = "it has not been connected yet"
        self.doubt = False
        """Whether its position is not trusted although Klipper does."""
        self._state = "startup"
        self._why = ""
        self._http: aiohttp.ClientSession | None = None
        self._socket: aiohttp.ClientWebSocketResponse | None = None
        self._reader: asyncio.Task[None] | None = None
        self._ids = itertools.count(1)
        self._asked: dict[int, asyncio.Future[Any]] = {}
        self._said: list[str] = []
        self._turn = asyncio.Lock()
        self._condition = Condition()
        self.until = self._condition.until

    @property
    def lost(self) -> str:
        """Why nothing can be sent."""
        if self.disconnected:
            return f"{self.url}: {self.disconnected}"
        if self._state in ("disconnected", "startup"):
            return f"Moonraker at {self.url} has no connection to Klipper ({self._state}); is it running?"
        return ""

    @property
    def halted(self) -> bool:
        """Whether Klipper accepts nothing until it is restarted."""
        return self._state in ("shutdown", "error")

    @property
    def trouble(self) -> str:
        """Klipper's state, with its own reason."""
        why = "".join(f": {line}" for line in self._why.strip().splitlines()[:1])
        return f"Klipper is in state {self._state}{why}"

    @property
    def alarm(self) -> str:
        """Why no motion may begin, and what to do."""
        if self.halted:
            return f"{self.trouble}; unlock restarts it, then home it"
        return f"Klipper prints {self.prints}; halt pauses that" if self.prints else ""

    @property
    def prints(self) -> str:
        """The file that Klipper carries out by itself; empty if there is none."""
        told = self.status.get("virtual_sdcard", {})
        if self.lost or self.halted or not told.get("is_active"):
            return ""
        return str(told.get("file_path")).rpartition("/")[2]

    @property
    def homed(self) -> bool:
        """Whether Klipper knows where x, y and z are: it is told again after a restart or an idle timeout."""
        axes = str(self.status.get("toolhead", {}).get("homed_axes", ""))
        return not self.lost and not self.halted and not self.doubt and set("xyz") <= set(axes)

    @homed.setter
    def homed(self, known: bool) -> None:
        self.doubt = not known

    async def open(self) -> None:
        """Connect and subscribe; raises OSError with the reason."""
        import aiohttp

        await self.close("it is being connected again")
        self._http = aiohttp.ClientSession()
        try:
            async with asyncio.timeout(CONNECT_S):
                address = self.url.replace("http", "ws", 1).rstrip("/") + "/websocket"
                self._socket = await self._http.ws_connect(address, heartbeat=CONNECT_S)
        except (aiohttp.ClientError, OSError, ValueError) as fault:  # a timeout is an OSError, too
            await self.close("it did not respond")
            raise OSError(
                f"Moonraker does not respond at {self.url} ({fault}); is it running?"
            ) from fault
        self.disconnected, self._state = "", "startup"
        self._reader = spawn(f"reading {self.url}", self._read(self._socket))
        try:
            key: dict[str, Any] = {"api_key": self.api_key} if self.api_key else {}
            await self.ask(
                "server.connection.identify",
                client_name="labrun",
                version="1",
                type="other",
                url="-",
                **key,
            )
            await self.learn()
        except MotionFault as fault:
            await self.close("it refused the connection")
            hint = "; give its API key as `api_key`" if "Unauthorized" in str(fault) else ""
            raise OSError(f"Moonraker at {self.url}: {fault}{hint}") from fault

    async def learn(self) -> None:
        """Ask what state Klipper is in, and for its reports if it is ready; raises MotionFault."""
        info = await self.ask("server.info")
        self._state = str(info.get("klippy_state"))
        if self._state not in ("disconnected", "startup"):  # Klipper itself knows better
            told = await self.ask("printer.info")
            self._state, self._why = str(told.get("state")), str(told.get("state_message"))
        if self._state == "ready":
            told = await self.ask("printer.objects.subscribe", objects=WATCHED)
            self.status = {}
            self._update(told.get("status"))
        self._condition.set()

    async def close(self, why: str) -> None:
        """Disconnect."""
        self.disconnected = why
        self._fail(Lost(f"{self.url}: {why}"))
        await end(self._reader)
        self._reader = None
        if self._socket is not None:
            await self._socket.close()
        if self._http is not None:
            await self._http.close()
        self._socket = self._http = None
        self._condition.set()

    async def ask(self, method: str, seconds: float | None = ANSWER_S, **params: Any) -> Any:
        """The result of a call; raises MotionFault with Moonraker's or Klipper's own words."""
        if self.disconnected or self._socket is None:
            raise NotConnected(f"{self.url}: {self.disconnected}")
        number = next(self._ids)
        answer = self._asked[number] = asyncio.get_running_loop().create_future()
        call = {"jsonrpc": "2.0", "method": method, "params": params, "id": number}
        try:
            async with asyncio.timeout(seconds):
                await self._socket.send_str(json.dumps(call))
                return await answer
        except TimeoutError:
            raise Silent(f"it did not answer {method} within {seconds:g} s") from None
        except (OSError, RuntimeError) as fault:  # the socket closes at this moment
            raise Lost(f"{self.url}: {fault}") from fault
        finally:
            del self._asked[number]

    async def run(self, script: str, seconds: float | None = ANSWER_S) -> list[str]:
        """Carry out a line; Klipper answers when it has taken it up. What it said; raises MotionFault."""
        async with self._turn:
            self._said.clear()
            try:
                await self.ask("printer.gcode.script", seconds, script=script)
            except Refused:
                with contextlib.suppress(MotionFault):
                    await self.learn()  # the news of a halt come a quarter of a second later
                raise
            said = list(self._said)
        if any("Unknown command" in line for line in said):
            raise NotThere(f"Klipper has nothing that does `{script}`")
        return said

    async def _read(self, socket: "aiohttp.ClientWebSocketResponse") -> None:
        async for message in socket:
            if message.type.name == "TEXT":
                told = json.loads(message.data)
                if isinstance(told, dict):
                    self._hear(told)
                    self._condition.set()
        if not self.disconnected:
            self.disconnected = "the connection was lost; is Moonraker running?"
            self._fail(Lost(f"{self.url}: {self.disconnected}"))
            self._condition.set()

    def _hear(self, told: dict[str, Any]) -> None:
        method, params = told.get("method"), told.get("params") or []
        answer = self._asked.get(told.get("id", 0))
        if answer is not None and not answer.done():
            if "error" in told:
                answer.set_exception(_refused(str(told["error"].get("message", told["error"]))))
            else:
                answer.set_result(told.get("result"))
        elif method == "notify_status_update" and params:
            self._update(params[0])
        elif method == "notify_gcode_response":
            self._said.extend(str(line) for line in params)
        elif (
            method in NOT_READY and self._state != NOT_READY[str(method)]
        ):  # else they are old news
            self._why = ""  # it follows
            self._halts(NOT_READY[str(method)])
        elif method == "notify_klippy_ready" and self._state != "ready":
            self._state = "startup"  # until it was asked for its reports

    def _update(self, status: Any) -> None:
        for name, fields in (status or {}).items():
            self.status.setdefault(name, {}).update(fields or {})
        state = self.status.get("webhooks", {}).get("state", self._state)
        self._why = str(self.status.get("webhooks", {}).get("state_message", self._why))
        if state != self._state:
            self._state = str(state)
            if self.halted:
                self._halts(self._state)

    def _halts(self, state: str) -> None:
        self._state = state
        self._fail(MotionFault(self.alarm or self.lost))

    def _fail(self, fault: MotionFault) -> None:
        for answer in self._asked.values():
            if not answer.done():
                answer.set_exception(fault)
                answer.exception()


def _refused(words: str) -> Refused:
    """Klipper's words up to the advice that it gives in further lines."""
    fault = Refused(f"it answered: {next(iter(words.strip().splitlines()), '')}")
    fault.error = next(
        (name for begin, name in REFUSALS.items() if words.startswith(begin)), fault.error
    )
    return fault
