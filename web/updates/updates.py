"""The namespace `/ui`: a snapshot for each browser, then numbered patches, at most ten a second."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import socketio
from pydantic import BaseModel
from socketio.exceptions import ConnectionRefusedError

from ...system.tasks import end, keep, spawn
from ..access.headers import Deadline
from ..local.refusal import Refusal
from ..models.control import ControlState
from ..models.updates import Notice, Patch, RunLog, RunPatch, Snapshot, WatchedRun

LOG = logging.getLogger("labrun")
NAMESPACE = "/ui"
EVERY_S = 0.1
LARGEST = 1_000_000

Kind = Literal["devices", "runs", "goals", "jogs", "launches"]
"""What a patch has entries of."""


@dataclass(frozen=True, slots=True)
class Source:
    """All that a snapshot has of a kind, by name, and the state of one; None: there is none now."""

    names: Callable[[], Iterable[str]]
    one: Callable[[str], BaseModel | None]


@dataclass(frozen=True, slots=True)
class Sources:
    """Where the present state comes from, and who does what browsers ask for."""

    kinds: Mapping[Kind, Source]
    control: Callable[[], ControlState]
    bench: Callable[[], str]
    watch: Callable[[str], Awaitable[WatchedRun]]
    signed_in: Callable[[Mapping[str, Any]], bool]
    beat: Callable[[str, str], None]
    session_closed: Callable[[str], None]
    stop: Callable[[str | None, str], Awaitable[BaseModel]]


class Updates:
    """Whatever changes is `touched`; its new state is read when a patch is sent."""

    sources: Sources
    """Known once it is open."""

    def __init__(self) -> None:
        self.seq = 0
        self._touched: dict[Kind, set[str]] = {kind: set() for kind in get_args(Kind)}
        self._control = False
        self._wake = asyncio.Event()
        self._pushing: asyncio.Task[None] | None = None
        self.sio: Any = socketio.AsyncServer(
            async_mode="asgi", transports=["websocket"], ping_interval=2, ping_timeout=2,
            max_http_buffer_size=LARGEST, cors_allowed_origins="*",  # the gate has already checked it
        )  # fmt: skip
        for answer in (
            self._connect, self._disconnect, self._snapshot, self._watch, self._unwatch, self._jog,
            self._stop,
        ):  # fmt: skip
            self.sio.on(answer.__name__[1:], answer, namespace=NAMESPACE)

    def open(self, sources: Sources) -> None:
        """Start pushing."""
        self.sources = sources
        self._pushing = keep("push patches to the browsers", self._push)

    async def close(self) -> None:
        """Stop pushing."""
        await end(self._pushing)
        await self.sio.shutdown()

    # --- what has changed

    def touch(self, kind: Kind, name: str) -> None:
        """Something of this kind has changed; sent with the next patch."""
        self._touched[kind].add(name)
        self._wake.set()

    def touch_control(self) -> None:
        """Control has changed hands, or was renewed."""
        self._control = True
        self._wake.set()

    def notice(self, notice: Notice) -> None:
        """Send a notice to everybody, now."""
        spawn("send a notice to the browsers", self._emit("notice", notice))

    async def run_patch(self, patch: RunPatch) -> None:
        """Send changes to those who watch a run."""
        await self._emit("run_patch", patch, f"run:{patch.run}")

    async def run_log(self, log: RunLog) -> None:
        """Send new log lines to those who watch a run."""
        await self._emit("log", log, f"run:{log.run}")

    def is_watched(self, run: str) -> bool:
        """True if somebody watches a run."""
        return bool(self.sio.manager.rooms.get(NAMESPACE, {}).get(f"run:{run}"))

    async def _push(self) -> None:
        while True:
            await self._wake.wait()
            await asyncio.sleep(EVERY_S)
            self._wake.clear()
            await self._emit("patch", self._patch())

    def _patch(self) -> Patch:
        self.seq += 1
        control = self.sources.control() if self._control else None
        self._control = False
        changed: dict[str, Any] = {}
        for kind, names in list(self._touched.items()):
            self._touched[kind] = set()
            changed[kind] = self._states(kind, names)
        return Patch(seq=self.seq, server_time_ms=time.time() * 1000, control=control, **changed)

    def _states(self, kind: Kind, names: Iterable[str]) -> dict[str, BaseModel | None]:
        """Their states; one that cannot be told is logged, and tried again with the next patch."""
        told: dict[str, BaseModel | None] = {}
        for name in names:
            try:
                told[name] = self.sources.kinds[kind].one(name)
            except Exception:  # whatever it was: the others have to be told
                LOG.exception("the state of %r (%s) cannot be told", name, kind)
                self._touched[kind].add(name)
        return told

    async def _emit(self, event: str, told: BaseModel, room: str | None = None) -> None:
        await self.sio.emit(event, told.model_dump(mode="json"), namespace=NAMESPACE, room=room)

    # --- messages from browsers

    def _whole(self) -> dict[str, Any]:
        now: dict[str, Any] = {
            kind: self._states(kind, source.names()) for kind, source in self.sources.kinds.items()
        }
        snapshot = Snapshot(
            seq=self.seq, server_time_ms=time.time() * 1000, control=self.sources.control(),
            bench=self.sources.bench(), **now,
        )  # fmt: skip
        return snapshot.model_dump(mode="json")

    async def _connect(self, session: str, environ: dict[str, Any], auth: Any = None) -> None:
        if not self.sources.signed_in(environ):
            raise ConnectionRefusedError("sign in first")
        await self.sio.emit("snapshot", self._whole(), namespace=NAMESPACE, to=session)

    async def _disconnect(self, session: str, reason: str = "") -> None:
        self.sources.session_closed(session)

    async def _snapshot(self, session: str, data: Any = None) -> dict[str, Any]:
        return self._whole()

    async def _watch(self, session: str, data: Any = None) -> dict[str, Any]:
        run = _text(data, "run")
        if run is None:
            return WatchedRun(ok=False, text="watch wants {run}").model_dump(mode="json")
        told = await self.sources.watch(run)
        if told.ok:
            # No await between this and the state below: no patch is lost between them.
            await self.sio.enter_room(session, f"run:{run}", namespace=NAMESPACE)
            told = await self.sources.watch(run)
        return told.model_dump(mode="json")

    async def _unwatch(self, session: str, data: Any = None) -> None:
        run = _text(data, "run")
        if run is not None:
            await self.sio.leave_room(session, f"run:{run}", namespace=NAMESPACE)

    async def _jog(self, session: str, data: Any = None) -> None:
        id = _text(data, "id")
        if id is not None:
            self.sources.beat(id, session)

    async def _stop(self, session: str, data: Any = None) -> dict[str, Any]:
        """Stop at once; but a delayed message must not stop what was started since."""
        until_ms = data.get("until_ms") if isinstance(data, dict) else None
        try:
            Deadline(until_ms if isinstance(until_ms, int | float) else None).check()
        except Refusal as late:
            return late.fault.model_dump()
        stopped = await self.sources.stop(_text(data, "press"), _text(data, "name") or "")
        return stopped.model_dump(mode="json")


def _text(data: Any, key: str) -> str | None:
    """A text in a browser's message; None if it is not there."""
    told = data.get(key) if isinstance(data, dict) else None
    return told if isinstance(told, str) else None
