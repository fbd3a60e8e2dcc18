"""Start a device server as a child process, and end it again."""

import asyncio
import contextlib
import json
import os
import signal
import subprocess
import sys
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .client import DeviceClient
from .link import ServerUnreachable
from .presence import FILE, alive, fingerprint
from .settings import ServerSettings

LOOK_S = 0.05
GREETING_S = 2.0
# What Windows calls SIGTERM ends a process at once, with its devices as they are.
PLEASE_END = getattr(signal, "CTRL_BREAK_EVENT", signal.SIGTERM)


class ServerFailed(Exception):
    """A device server that did not start, with its own words on why."""


@dataclass(slots=True)
class RunningServer:
    """A device server that answers; `process` is None where an earlier engine had started it."""

    process: asyncio.subprocess.Process | None
    url: str
    devices: list[str]
    pid: int

    async def stop(self, timeout_s: float = 5.0) -> None:
        """Let it bring its devices into the safe state and end; after `timeout_s` it is killed."""
        self._signal(PLEASE_END)
        if not await self._ended(timeout_s):
            self._signal(getattr(signal, "SIGKILL", signal.SIGTERM))
            await self._ended(timeout_s)

    async def ended(self) -> None:
        """Wait until the process has ended, by itself or otherwise."""
        if self.process is not None:
            await self.process.wait()
        else:
            while alive(self.pid):  # noqa: ASYNC110 - a stranger's child tells nobody
                await asyncio.sleep(LOOK_S)

    def _signal(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if self.process is not None:
                self.process.send_signal(number)
            else:
                os.kill(self.pid, number)

    async def _ended(self, timeout_s: float) -> bool:
        try:
            async with asyncio.timeout(timeout_s):
                await self.ended()
        except TimeoutError:
            return False
        return True


async def start_server(
    config: dict[str, Any], folder: Path, *, timeout_s: float = 20
) -> RunningServer:
    """Start a server with these settings (see `settings.py`); raises ServerFailed.

    `folder` keeps its settings and its log, and its ledger where the settings name no other. One
    that an engine left behind here with the same settings goes on to be used: it knows its goals.
    One whose owner still lives is left alone, and this one is not started.
    """
    try:
        return await _start_or_adopt(config, folder, timeout_s)
    except OSError as fault:
        words = f"{fault.strerror or fault}: {fault.filename or folder}"
        raise ServerFailed(f"the device server cannot be started: {words}") from fault


async def _start_or_adopt(config: dict[str, Any], folder: Path, timeout_s: float) -> RunningServer:
    await asyncio.to_thread(folder.mkdir, parents=True, exist_ok=True)
    settings: dict[str, Any] = {"folder": str(folder), **config}
    left = await _left_behind(Path(settings["folder"]), settings.get("token"))
    if left is not None:
        if left.owner != os.getpid() and alive(left.owner):
            raise ServerFailed(
                f"{', '.join(left.devices)} at {left.url} is served from {settings['folder']} already, "
                f"by process {left.owner}; end that one first, or choose another folder"
            )
        if left.same(fingerprint(ServerSettings.model_validate(settings)), settings.get("port")):
            return RunningServer(None, left.url, left.devices, left.pid)
        await RunningServer(None, left.url, left.devices, left.pid).stop()
    path = folder / "server_settings.json"
    path.write_text(json.dumps(settings), encoding="utf-8")
    return await _start(path, folder / "server.log", timeout_s)


async def _start(settings: Path, log: Path, timeout_s: float) -> RunningServer:
    with log.open("ab") as sink:
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-P", "-m", "labrun.drivers.serve", str(settings),
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=sink,
            **_apart(),
        )  # fmt: skip
    try:
        async with asyncio.timeout(timeout_s):
            assert process.stdout is not None
            line = await process.stdout.readline()
            said = json.loads(line) if line.strip() else {}
    except (TimeoutError, ValueError):
        said = {"error": f"it did not say that it is ready within {timeout_s:g} s"}
    except BaseException:
        await RunningServer(process, "", [], process.pid).stop()
        raise
    if said.get("ready"):
        return RunningServer(process, str(said["url"]), list(said["devices"]), process.pid)
    await RunningServer(process, "", [], process.pid).stop()
    reason = said.get("error") or f"it ended at once; the last of its log: {_tail(log)}"
    raise ServerFailed(f"the device server did not start: {reason}")


def _apart() -> dict[str, Any]:
    """A session of its own: Ctrl-C in the terminal is the engine's to hear, which ends it in order."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def _tail(log: Path, lines: int = 3) -> str:
    with log.open(encoding="utf-8", errors="replace") as file:
        return " | ".join(line.strip() for line in deque(file, lines)) or "(empty)"


@dataclass(frozen=True, slots=True)
class _Left:
    pid: int
    url: str
    devices: list[str]
    settings: str
    owner: int | None

    def same(self, fingerprint: str, port: int | None) -> bool:
        return self.settings == fingerprint and (not port or self.url.endswith(f":{port}"))


async def _left_behind(folder: Path, token: str | None) -> _Left | None:
    """The server that still serves this folder, if there is one that answers."""
    try:
        words = json.loads((folder / FILE).read_bytes())
        left = _Left(
            words["pid"], words["url"], words["devices"], words["settings"], words.get("owner")
        )
        client = DeviceClient(left.url, token)
        try:
            # The boot tells our server from a stranger that got the same port since.
            found = await client.open(GREETING_S)
        finally:
            await client.close()
    except (OSError, ValueError, KeyError, ServerUnreachable):
        return None
    return left if found.boot == words["boot"] else None
