"""The namespace `/ui`: a snapshot for each browser, then numbered patches, ten a second at most."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import socketio
from pydantic import BaseModel
from socketio.exceptions import ConnectionRefusedError

from ..guard.headers import Deadline
from ..guard.refusal import Refusal
from ..models.control import ControlState
from ..models.push import Notice, Patch, RunLog, RunPatch, Snapshot, Watched

NAMESPACE = "/ui"
EVERY_S = 0.1
LARGEST = 1_000_000
KINDS = ("devices", "runs", "goals", "jogs", "launches")

One = Callable[[str], BaseModel | None]


@dataclass(slots=True)
class Sources:
    """Where the present state comes from: all of a kind, and one of it by its name."""

    all: Mapping[str, Callable[[], Mapping[str, BaseModel]]]
    one: Mapping[str, One]
    control: Callable[[], ControlState]
    bench: Callable[[], str]
    watch: Callable[[str], Awaitable[Watched]]
    signed_in: Callable[[Mapping[str, Any]], bool]
    beat: Callable[[str, str], None]
    gone: Callable[[str], None]
    stop: Callable[[str | None], Awaitable[BaseModel]]


@dataclass(slots=True)
class Push:
    """Everything that changes is `touched`; what it has become is asked for when a patch goes out."""

    seq: int = 0
    sources: Sources | None = None
    _touched: dict[str, set[str]] = field(default_factory=lambda: {kind: set() for kind in KINDS})
    _control: bool = False
    _wake: asyncio.Event = field(default_factory=asyncio.Event)
    _task: "asyncio.Task[None] | None" = None
    _loop: asyncio.AbstractEventLoop | None = None
    sio: Any = None

    def open(self, sources: Sources) -> None:
        """Begin to tell."""
        self.sources = sources
        self._loop = asyncio.get_running_loop()
        self.sio = socketio.AsyncServer(
            async_mode="asgi", transports=["websocket"], ping_interval=2, ping_timeout=2,
            max_http_buffer_size=LARGEST, cors_allowed_origins="*",  # the guard has looked before
        )  # fmt: skip
        on = self.sio.on
        on("connect", self._connect, namespace=NAMESPACE)
        on("disconnect", self._disconnect, namespace=NAMESPACE)
        on("snapshot", self._snapshot, namespace=NAMESPACE)
        on("watch", self._watch, namespace=NAMESPACE)
        on("unwatch", self._unwatch, namespace=NAMESPACE)
        on("jog", self._jog, namespace=NAMESPACE)
        on("stop", self._stop, namespace=NAMESPACE)
        self._task = asyncio.create_task(self._flush())

    async def close(self) -> None:
        """Tell nothing more."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        if self.sio is not None:
            await self.sio.shutdown()

    # --- what has changed

    def touch(self, kind: str, name: str) -> None:
        """Something of this kind is not what it was; told with the next patch."""
        self._touched[kind].add(name)
        self._wake.set()

    def touch_control(self) -> None:
        """Control has changed hands, or was renewed."""
        self._control = True
        self._wake.set()

    def notice(self, notice: Notice) -> None:
        """Tell everybody something, now. May be called from any thread."""
        if self._loop is not None and self.sio is not None:
            self._loop.call_soon_threadsafe(self._emit_soon, "notice", notice, None)

    def _emit_soon(self, event: str, told: BaseModel, room: str | None) -> None:
        work = self.sio.emit(event, told.model_dump(mode="json"), namespace=NAMESPACE, room=room)
        task = asyncio.ensure_future(work)
        _PENDING.add(task)
        task.add_done_callback(_PENDING.discard)

    async def run_patch(self, patch: RunPatch) -> None:
        """Tell those who watch a run."""
        await self._emit("run_patch", patch, f"run:{patch.run}")

    async def run_log(self, log: RunLog) -> None:
        """Tell those who watch a run of new lines."""
        await self._emit("log", log, f"run:{log.run}")

    def watched(self, run: str) -> bool:
        """True where somebody watches a run."""
        rooms = self.sio.manager.rooms.get(NAMESPACE, {}) if self.sio is not None else {}
        return bool(rooms.get(f"run:{run}"))

    async def _flush(self) -> None:
        while True:
            await self._wake.wait()
            await asyncio.sleep(EVERY_S)
            self._wake.clear()
            await self._emit("patch", self._patch(), None)

    def _patch(self) -> Patch:
        assert self.sources is not None
        self.seq += 1
        changed: dict[str, Any] = {}
        for kind, names in self._touched.items():
            changed[kind] = {name: self.sources.one[kind](name) for name in names}
            names.clear()
        control = self.sources.control() if self._control else None
        self._control = False
        return Patch(seq=self.seq, server_time_ms=time.time() * 1000, control=control, **changed)

    async def _emit(self, event: str, told: BaseModel, room: str | None) -> None:
        await self.sio.emit(event, told.model_dump(mode="json"), namespace=NAMESPACE, room=room)

    # --- what browsers say

    def _whole(self) -> dict[str, Any]:
        sources = self.sources
        assert sources is not None
        now = {kind: dict(all_of()) for kind, all_of in sources.all.items()}
        told: dict[str, Any] = {**now, "control": sources.control(), "bench": sources.bench()}
        snapshot = Snapshot(seq=self.seq, server_time_ms=time.time() * 1000, **told)
        return snapshot.model_dump(mode="json")

    async def _connect(self, session: str, environ: dict[str, Any], auth: Any = None) -> None:
        assert self.sources is not None
        if not self.sources.signed_in(environ):
            raise ConnectionRefusedError("sign in first")
        await self.sio.emit("snapshot", self._whole(), namespace=NAMESPACE, to=session)

    async def _disconnect(self, session: str, reason: str = "") -> None:
        assert self.sources is not None
        self.sources.gone(session)

    async def _snapshot(self, session: str, data: Any = None) -> dict[str, Any]:
        return self._whole()

    async def _watch(self, session: str, data: Any = None) -> dict[str, Any]:
        assert self.sources is not None
        run = data.get("run") if isinstance(data, dict) else None
        if not isinstance(run, str):
            return Watched(ok=False, text="watch wants {run}").model_dump(mode="json")
        told = await self.sources.watch(run)
        if told.ok:
            # No turn of the loop between this and the state below: no patch is lost between them.
            await self.sio.enter_room(session, f"run:{run}", namespace=NAMESPACE)
            told = await self.sources.watch(run)
        return told.model_dump(mode="json")

    async def _unwatch(self, session: str, data: Any = None) -> None:
        run = data.get("run") if isinstance(data, dict) else None
        if isinstance(run, str):
            await self.sio.leave_room(session, f"run:{run}", namespace=NAMESPACE)

    async def _jog(self, session: str, data: Any = None) -> None:
        assert self.sources is not None
        id = data.get("id") if isinstance(data, dict) else None
        if isinstance(id, str):
            self.sources.beat(id, session)

    async def _stop(self, session: str, data: Any = None) -> dict[str, Any]:
        """At once; but one that lay in a stalled line must not stop what was started since."""
        assert self.sources is not None
        asked = data if isinstance(data, dict) else {}
        until_ms, press = asked.get("until_ms"), asked.get("press")
        try:
            Deadline(until_ms if isinstance(until_ms, int | float) else None).check()
        except Refusal as late:
            return late.fault.model_dump()
        stopped = await self.sources.stop(press if isinstance(press, str) else None)
        return stopped.model_dump(mode="json")


_PENDING: set[asyncio.Future[Any]] = set()
