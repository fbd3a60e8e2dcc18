"""The device server's side of the wire: the events of the namespace `/action`."""

import asyncio
import contextlib
import functools
import logging
import math
import time
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

import socketio
from pydantic import ValidationError
from socketio.exceptions import ConnectionRefusedError

from ...schemas.messages import (
    NAMESPACE,
    DeviceDescription,
    Goal,
    GoalReport,
    GoalState,
    LeaseRequest,
    ServerDescription,
)
from ...schemas.model import first_fault
from ...system.extras import in_words
from ...system.tasks import end, keep
from .device import ServedDevice
from .execution import Execution
from .gate import Brake, why_not
from .lease import Refused
from .ledger import Ledger, LedgerFault
from .packet import Packet
from .wire import wire

BEAT_S = 1.0
FLUSH_S = 1.0
REFUSALS_KEPT = 10_000
OPEN_AGAIN_S = 0.5
OPEN_AGAIN_AT_MOST_S = 10.0
"""How soon an instrument out of reach is tried again: at first, and at the latest."""
MAX_BY = 200
"""Characters of the name of whoever stops a device."""
MAX_MESSAGE_BYTES = 64 * 1024 * 1024

LOG = logging.getLogger("labrun")

Answer = dict[str, Any]


class DeviceClosed(Exception):
    """A device whose driver cannot connect to its hardware."""

    def __init__(self, device: str, fault: Exception) -> None:
        words = str(fault) if isinstance(fault, OSError) else in_words(fault)
        super().__init__(f"device {device} cannot be opened: {words}")


class DeviceServer:
    """Serves devices to all clients; every request is answered at once."""

    def __init__(
        self, ledger: Ledger, token: str | None = None, listens_on: str = "127.0.0.1"
    ) -> None:
        self.ledger = ledger
        self.devices: dict[str, ServedDevice] = {}
        self.closed: dict[str, DeviceDescription] = {}
        """Those whose instruments are out of reach, as they are described meanwhile."""
        self.on_opened: Callable[[str], None] = lambda name: None
        """Called with the name of one whose instrument has come into reach."""
        self.sessions: set[str] = set()
        self._listens_on = listens_on
        self._brake = Brake(token)
        self._outbox: asyncio.Queue[tuple[str, Answer, set[str]]] = asyncio.Queue()
        self._tasks: list[asyncio.Task[None]] = []
        self._refusals: dict[tuple[str, int], Refused] = {}
        # Goals and cancels are answered one at a time, in the order in which they came: what one
        # finds in the ledger, none changes before it has written. A stop waits for none of them.
        self._in_order = asyncio.Lock()
        self._sio = socketio.AsyncServer(
            serializer=Packet,
            async_mode="asgi",
            transports=["websocket"],
            ping_interval=2,
            ping_timeout=2,
            max_http_buffer_size=MAX_MESSAGE_BYTES,
            cors_allowed_origins="*",  # the gate decides, by Host and Origin alone
        )
        self.app = socketio.ASGIApp(self._sio)
        self._listen()

    def _listen(self) -> None:
        on = self._sio.on
        on("connect", self._connect, namespace=NAMESPACE)
        on("disconnect", self._disconnect, namespace=NAMESPACE)
        for event, answer in (
            ("describe", self._describe),
            ("lease", self._lease),
            ("release", self._release),
            ("goal", self._goal),
            ("cancel", self._cancel),
            ("query", self._query),
            ("stop", self._stop),
            ("picture", self._picture),
        ):
            on(event, _always_answered(answer), namespace=NAMESPACE)
        on("*", self._unknown_event, namespace=NAMESPACE)

    async def open(
        self, devices: Iterable[ServedDevice], anew: Callable[[str], ServedDevice] | None = None
    ) -> None:
        """Open every device; raises DeviceClosed for the first that cannot be opened.

        With `anew`, which makes a device once more, it goes on without those that cannot, and tries
        them again: meanwhile clients are refused, with the reason.
        """
        abandoned = self.ledger.abandoned() | self.ledger.touched
        for device in devices:
            try:
                await self._open(device, abandoned)
            except DeviceClosed:
                if anew is None:
                    raise
                await device.abandon()
        self._tasks = [keep("outbox", self._send), keep("signs of life", self._beat)]
        if anew is not None:
            for name in self.closed:
                again = functools.partial(self._open_again, name, anew, abandoned)
                self._tasks.append(keep(f"open {name}", again))

    async def _open(self, device: ServedDevice, abandoned: set[str]) -> None:
        try:
            await device.open(make_safe=device.name in abandoned)
        except Exception as fault:  # a driver may raise anything if its hardware is missing
            closed = DeviceClosed(device.name, fault)
            words = f"{closed}; its server tries again every {OPEN_AGAIN_AT_MOST_S:g} s"
            status = {"fault": words}
            self.closed[device.name] = device.describe().model_copy(update={"status": status})
            raise closed from fault
        self.devices[device.name] = device
        if self.closed.pop(device.name, None) is not None:
            self.on_opened(device.name)

    async def _open_again(
        self, name: str, anew: Callable[[str], ServedDevice], abandoned: set[str]
    ) -> None:
        pause_s = OPEN_AGAIN_S
        while name in self.closed:
            await asyncio.sleep(pause_s)
            pause_s = min(2 * pause_s, OPEN_AGAIN_AT_MOST_S)
            device = anew(name)
            try:
                await self._open(device, abandoned)
            except DeviceClosed:
                await device.abandon()

    async def make_safe(self) -> None:
        """Stop every device and report how its goals ended, while clients are still connected."""
        await asyncio.gather(*(device.wind_down() for device in self.devices.values()))
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(FLUSH_S):
                await self._outbox.join()

    async def close(self) -> None:
        """Release the devices, leave nothing running, and complete the ledger."""
        await asyncio.gather(*(device.close() for device in self.devices.values()))
        await end(*self._tasks)
        await self._sio.shutdown()
        self.ledger.close()

    @property
    def calm(self) -> bool:
        """True if no client is connected and no device is in use."""
        return not self.sessions and self.idle

    @property
    def idle(self) -> bool:
        """True if no device is in use, whoever looks on."""
        return all(device.calm for device in self.devices.values())

    def tell(self, event: str, payload: Answer, followers: set[str]) -> None:
        """Queue an event for all clients; files go to the followers only."""
        if self.sessions:
            self._outbox.put_nowait((event, payload, followers))

    async def _send(self) -> None:
        # A single sender keeps the order of events.
        while True:
            event, payload, followers = await self._outbox.get()
            try:
                await self._send_one(event, payload, followers)
            except Exception:  # one message that cannot be sent must not silence the rest
                LOG.exception("%s could not be sent", event)
            finally:
                self._outbox.task_done()

    async def _send_one(self, event: str, payload: Answer, followers: set[str]) -> None:
        if "files" not in payload:
            await self._sio.emit(event, payload, namespace=NAMESPACE)
            return
        bare = {name: value for name, value in payload.items() if name != "files"}
        for session in self.sessions.copy():
            await self._sio.emit(
                event, payload if session in followers else bare, to=session, namespace=NAMESPACE
            )

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(BEAT_S)
            for device in self.devices.values():
                device.beat()
            for name, described in self.closed.items():
                self.tell("status", {"device": name, **described.status}, set())

    async def _connect(self, session: str, environ: Any, auth: Any = None) -> None:
        host, origin = environ.get("HTTP_HOST", ""), environ.get("HTTP_ORIGIN")
        if (words := why_not(self._listens_on, host, origin)) is not None:
            raise ConnectionRefusedError(words)
        given = auth.get("token") if isinstance(auth, dict) else None
        if self._brake.is_on and given is None:
            words = (
                "a token is required (the lab's `token`); without, only its own user may connect"
            )
            raise ConnectionRefusedError(words)
        if not await self._brake.look(given):
            raise ConnectionRefusedError("the token is wrong, or too many wrong ones came at once")
        self.sessions.add(session)

    async def _disconnect(self, session: str, reason: str = "") -> None:
        self.sessions.discard(session)

    async def _describe(self, session: str, data: Answer) -> Answer:
        described = {name: device.describe() for name, device in self.devices.items()} | self.closed
        mark = data.get("mark")
        return ServerDescription(
            boot=self.ledger.boot, ledger=self.ledger.id, mark=self.ledger.mark, devices=described,
            continues=not mark or await self.ledger.queued(self.ledger.has, str(mark)),
        ).model_dump()  # fmt: skip

    async def _lease(self, session: str, data: Answer) -> Answer:
        request = LeaseRequest.model_validate(data)
        device = self._device(request.device)
        epoch = await device.take_lease(request, session)
        lapsed = device.lapsed
        return {"epoch": epoch, "boot": self.ledger.boot, "device": device.name, "lapsed": lapsed}

    async def _release(self, session: str, data: Answer) -> Answer:
        device = self._device(data["device"])
        return {"released": await device.release(data["owner"], data.get("epoch"))}

    async def _goal(self, session: str, data: Answer) -> Answer:
        known = self._under_way(data.get("id"), session)
        if known is None:
            stops = {name: device.stops for name, device in self.devices.items()}
            async with self._in_order:
                known = self._under_way(data.get("id"), session)
                if known is None:
                    try:
                        return await self._new_goal(session, data, stops)
                    except (Refused, ValidationError):
                        # The ledger takes no id twice; what is in it is answered, not refused.
                        known = await self._known(data.get("id"), session)
                        if known is None:
                            raise
        self._still_wanted(data)
        return {"dup": True, "mark": self.ledger.mark, **wire(known)}

    def _still_wanted(self, data: Answer) -> None:
        """A goal that is sent again is still wanted; one from a lease that is over is not."""
        execution = self._running(data["id"])
        if execution is not None and execution.goal.epoch == data.get("epoch"):
            execution.context.wanted_at = time.monotonic()

    async def _new_goal(self, session: str, data: Answer, stops: dict[str, int]) -> Answer:
        goal = Goal.model_validate(data)
        if goal.boot != self.ledger.boot:
            raise Refused("STALE_BOOT", "the device server has been restarted since; use query")
        self._refuse_again(goal)
        device = self._device(goal.device)
        try:
            execution = await device.accept(goal, session, stops.get(device.name, 0))
        except Refused as refusal:
            self._remember(goal, refusal)
            raise
        mark = self.ledger.mark
        return {"id": goal.id, "state": execution.state, "seq": execution.seq, "mark": mark}

    def _refuse_again(self, goal: Goal) -> None:
        """A refusal is final: a late copy must not start what its sender counts as never done."""
        refusal = self._refusals.get((goal.id, goal.epoch))
        if refusal is not None:
            raise Refused(refusal.code, refusal.message, **refusal.more)

    def _remember(self, goal: Goal, refusal: Refused) -> None:
        # In memory only: a copy that outlives the server is refused because of its boot.
        self._refusals[goal.id, goal.epoch] = refusal
        if len(self._refusals) > REFUSALS_KEPT:
            del self._refusals[next(iter(self._refusals))]

    async def _cancel(self, session: str, data: Answer) -> Answer:
        goal_id = _text(data, "id")
        running = self._running(goal_id)
        if running is None:
            async with self._in_order:
                running = self._running(goal_id)
                if running is None:
                    return {"state": await self._buried(goal_id, data.get("boot"))}
        return {"state": running.cancel()}

    async def _buried(self, goal_id: str, boot: str | None) -> GoalState:
        """The state of a goal that does not run; one of this boot that is not known can never start.

        One that was sent to an earlier boot may have been done, and an older ledger put back since.
        """
        known = await self.ledger.queued(self.ledger.report, goal_id)
        if known is not None:
            return known.state
        if boot is not None and boot != self.ledger.boot:
            raise Refused("STALE_BOOT", "the device server has been restarted since; use query")
        await self.ledger.queued(self.ledger.bury, goal_id)
        return "CANCELED"

    async def _query(self, session: str, data: Answer) -> Answer:
        async with self._in_order:
            if "since" in data:
                since = self.ledger.queued(self.ledger.reports_since, int(data["since"]))
                found = {report.id: wire(report) for report in await since}
            else:
                known = {i: await self._known(i, session) for i in data["ids"]}
                found = {i: None if r is None else wire(r) for i, r in known.items()}
            mark = self.ledger.mark
        return {"boot": self.ledger.boot, "ledger": self.ledger.id, "mark": mark, "goals": found}

    async def _stop(self, session: str, data: Answer) -> Answer:
        name = data.get("device")
        if name is not None and name not in self.closed:
            self._device(name)
        devices = [device for device in self.devices.values() if name in (None, device.name)]
        timeout_s = float(data.get("timeout_s") or math.inf)
        by = str(data.get("by") or "")[:MAX_BY]
        words = await asyncio.gather(
            *(
                device.stop(timeout_s, by=by, by_others=_is_other(device, session))
                for device in devices
            )
        )
        answers = dict(zip([device.name for device in devices], words, strict=True))
        for closed, described in self.closed.items():
            if name in (None, closed):
                answers[closed] = False, f"{closed} may not be safe: {described.status['fault']}"
        return {
            "safe": all(safe for safe, _ in answers.values()),
            "message": "; ".join(message for _, message in answers.values()),
            "devices": {d: {"safe": safe, "message": m} for d, (safe, m) in answers.items()},
        }

    async def _picture(self, session: str, data: Answer) -> Answer:
        device = self._device(str(data.get("device")))
        return (await device.look(data.get("above") is True)).model_dump(exclude_none=True)

    async def _unknown_event(self, event: str, session: str, *data: Any) -> Answer:
        return {"ok": False, "code": "EXCEPTION", "message": f"there is no request {event!r}"}

    def _device(self, name: str) -> ServedDevice:
        device = self.devices.get(name)
        if device is None and name in self.closed:
            raise Refused("REJECTED", self.closed[name].status["fault"])
        if device is None:
            there = ", ".join(sorted(self.devices))
            raise Refused("UNKNOWN_DEVICE", f"there is no device {name!r} here; there is {there}")
        return device

    def _running(self, goal_id: Any) -> Execution | None:
        every = (device.running.get(goal_id) for device in self.devices.values())
        return next((execution for execution in every if execution is not None), None)

    def _under_way(self, goal_id: Any, session: str) -> GoalReport | None:
        """The report on a running goal; a client that asks for it will be sent its outcome."""
        running = self._running(goal_id)
        if running is None:
            return None
        running.followers.add(session)
        return running.report()

    async def _known(self, goal_id: Any, session: str) -> GoalReport | None:
        """What is known about a goal, running or not; asked in order, so that none is overlooked."""
        known = self._under_way(goal_id, session)
        if known is None and isinstance(goal_id, str):
            known = await self.ledger.queued(self.ledger.report, goal_id)
        return known


def _always_answered(
    answer: Callable[[str, Answer], Awaitable[Answer]],
) -> Callable[..., Awaitable[Answer]]:
    """Turn every exception into an answer: python-socketio would send none."""

    async def answered(session: str, data: Any = None) -> Answer:
        try:
            return {"ok": True, **await answer(session, data if isinstance(data, dict) else {})}
        except Refused as refused:
            return refused.answer()
        except ValidationError as fault:
            return Refused("INVALID", first_fault(fault)).answer()
        except LedgerFault as fault:
            return Refused("REJECTED", str(fault)).answer()
        except Exception as fault:  # the wire's promise: every request gets an answer
            LOG.exception("a request could not be answered")
            return Refused("EXCEPTION", f"{type(fault).__name__}: {fault}").answer()

    return answered


def _text(data: Answer, name: str) -> str:
    value = data.get(name)
    if not isinstance(value, str) or not value:
        raise Refused("INVALID", f"{name} must be a string")
    return value


def _is_other(device: ServedDevice, session: str) -> bool:
    return device.lease.holder is None or device.lease.holder.session != session
