"""Start a device server as a child process, and stop it again."""

import asyncio
import contextlib
import json
import os
import subprocess
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...system.files import write_whole
from ...system.process import AT_ONCE, PLEASE_END, Process, alive, start_python, stop
from ...system.tasks import end, spawn
from ..server.server_file import FILE, SETTINGS, fingerprint
from ..server.settings import ServerSettings
from .client import DeviceClient
from .environment import fault_of
from .link import ServerUnreachable

LOOK_S = 0.05
GREETING_S = 2.0
END_S = 5.0
OWN_END_S = 15.0
"""What a server may take to end, beside twice the lab's `stop_grace`: to make safe, and to close."""
QUIET_S = 3.0
"""A start or an end that takes longer is told."""
FIRST_PAUSE_S = 0.5
DEATHS_AT_MOST = 4
CALM_S = 60.0
"""A server that has lived for this long is trusted anew."""

Say = Callable[[str], None]


class ServerFailed(Exception):
    """A device server that did not start, with its own error message; `again`: it may the next time."""

    again = False


@dataclass(slots=True)
class RunningServer:
    """A device server that responds; `process` is None if an earlier engine started it."""

    process: Process | None
    url: str
    devices: list[str]
    pid: int
    stop_grace_s: float = 10.0
    say: Say = lambda text: None

    async def stop(self, timeout_s: float | None = None) -> None:
        """Let it bring its devices into the safe state and exit; after `timeout_s` it is killed."""
        timeout_s = timeout_s or 2 * self.stop_grace_s + OWN_END_S
        words = f"waiting for {', '.join(self.devices)} to be safe, {timeout_s:g} s at most (`stop_grace`)"
        with told_late(self.say, words):
            await self._stop(timeout_s)

    async def _stop(self, timeout_s: float) -> None:
        if self.process is not None:
            await stop(self.process, timeout_s)
            return
        for number in (PLEASE_END, AT_ONCE):
            # Windows' for a process that is gone, or one of another console: OSError or SystemError.
            with contextlib.suppress(OSError, SystemError, TimeoutError):
                os.kill(self.pid, number)
                async with asyncio.timeout(timeout_s):
                    await self.ended()
                break

    async def ended(self) -> None:
        """Wait until the process has ended."""
        if self.process is not None:
            await self.process.wait()
        else:
            while alive(self.pid):  # noqa: ASYNC110 - another process's child cannot be awaited
                await asyncio.sleep(LOOK_S)

    async def hear(self) -> None:
        """Tell which instruments come into reach, for as long as the process speaks."""
        said = self.process.stdout if self.process is not None else None
        while said is not None and (line := await said.readline()):
            with contextlib.suppress(ValueError, KeyError):
                self.say(f"{json.loads(line)['opened']} at {self.url}: its instrument is in reach")


@contextlib.contextmanager
def told_late(say: Say, words: str) -> Iterator[None]:
    """Say what is waited for, once that takes longer than a moment."""
    late = asyncio.get_running_loop().call_later(QUIET_S, say, words)
    try:
        yield
    finally:
        late.cancel()


async def keep_running(
    server: RunningServer, config: dict[str, Any], folder: Path, *, timeout_s: float = 60
) -> None:
    """Start a server again that has died, at its address, after growing pauses.

    Returns when it dies too often, or cannot be started. Its ledger is still there, so it knows its goals.
    """
    names, clock, log = (
        ", ".join(server.devices),
        asyncio.get_running_loop().time,
        folder / "server.log",
    )
    config = {**config, "port": int(server.url.rpartition(":")[2])}
    deaths, began, fault = 0, clock(), ""
    while True:
        hearing = spawn(f"hear the server of {names}", server.hear())
        try:
            await server.ended()
        finally:
            await end(hearing)
        deaths = 1 if clock() - began > CALM_S else deaths + 1
        fault = fault or f"the server of {names} has died, see {log}"
        if deaths > DEATHS_AT_MOST:
            server.say(f"{fault}; {deaths} times, so it is given up")
            return
        pause_s = FIRST_PAUSE_S * 2 ** (deaths - 1)
        server.say(f"{fault}; it starts again in {pause_s:g} s")
        await asyncio.sleep(pause_s)
        began = clock()
        # Rather than to be given up for an instrument that is gone, its last one serves without.
        patient = config.get("patient", False) and deaths == DEATHS_AT_MOST
        again = {**config, "patient": patient}
        try:
            new = await start_server(again, folder, timeout_s=timeout_s, say=server.say)
        except ServerFailed as failed:
            fault = f"{names}: {failed}"
        else:
            fault, server.process, server.pid = "", new.process, new.pid
            server.say(f"{names} at {server.url} again")


async def start_patiently(
    config: dict[str, Any], folder: Path, *, timeout_s: float = 60, say: Say = lambda text: None
) -> RunningServer:
    """Start a server; hardware that does not answer yet is tried twice more. Raises ServerFailed."""
    for pause_s in (FIRST_PAUSE_S, 2 * FIRST_PAUSE_S):
        try:
            return await start_server(config, folder, timeout_s=timeout_s, say=say)
        except ServerFailed as fault:
            if not fault.again:
                raise
            joined = " It" if str(fault).endswith("?") else "; it"
            say(f"{fault}{joined} is tried again in {pause_s:g} s")
        await asyncio.sleep(pause_s)
    return await start_server(config, folder, timeout_s=timeout_s, say=say)


async def start_server(
    config: dict[str, Any], folder: Path, *, timeout_s: float = 60, say: Say = lambda text: None
) -> RunningServer:
    """Start a server with these settings (see `settings.py`); raises ServerFailed.

    `folder` keeps its settings and its log, and its ledger unless the settings name another. A
    server that an engine left behind here with the same settings is reused: it knows its goals.
    If its owner is still running, it is left alone and no new one is started.
    """
    try:
        server = await _start_or_adopt(config, folder, timeout_s, say)
    except OSError as fault:
        words = f"{fault.strerror or fault}: {fault.filename or folder}"
        if (python := config.get("python")) is not None and fault.filename == python:
            words = await fault_of(python) or words
        raise ServerFailed(f"the device server cannot be started: {words}") from fault
    server.stop_grace_s, server.say = config.get("stop_grace_s", server.stop_grace_s), say
    return server


async def _start_or_adopt(
    config: dict[str, Any], folder: Path, timeout_s: float, say: Say
) -> RunningServer:
    await asyncio.to_thread(folder.mkdir, parents=True, exist_ok=True)
    settings: dict[str, Any] = {"folder": str(folder), **config}
    left = await _left_behind(Path(settings["folder"]), settings.get("token"))
    if left is not None:
        if left.owner != os.getpid() and alive(left.owner):
            raise ServerFailed(
                f"{', '.join(left.devices)} at {left.url} is already served from {settings['folder']}, "
                f"by process {left.owner}; stop that process first, or choose another folder"
            )
        if left.same(fingerprint(ServerSettings.model_validate(settings)), settings.get("port")):
            return RunningServer(None, left.url, left.devices, left.pid)
        await RunningServer(None, left.url, left.devices, left.pid).stop()
    path = folder / SETTINGS
    write_whole(path, json.dumps(settings).encode(), mode=0o600, sync=False)  # it may hold a token
    names = ", ".join(settings["devices"])
    words = f"waiting for the server of {names} to start, {timeout_s:g} s at most (`start_timeout`)"
    with told_late(say, words):
        return await _start(path, folder / "server.log", timeout_s, settings.get("python"), say)


async def _start(
    settings: Path, log: Path, timeout_s: float, python: str | None, say: Say
) -> RunningServer:
    with log.open("ab") as sink:
        process = await start_python(
            "labrun.drivers.server.serve", str(settings), python=python,
            stdout=subprocess.PIPE, stderr=sink,
        )  # fmt: skip
    try:
        async with asyncio.timeout(timeout_s):
            assert process.stdout is not None
            line = await process.stdout.readline()
            said: dict[str, Any] = json.loads(line) if line.strip() else {}
    except (TimeoutError, ValueError):
        said = {"error": f"it did not report ready within {timeout_s:g} s"}
    except BaseException:  # a cancel as well
        await stop(process, END_S)
        raise
    if said.get("ready"):
        for words in said.get("closed", {}).values():
            say(words)
        return RunningServer(process, str(said["url"]), list(said["devices"]), process.pid)
    if not said:  # its end is only just coming, and no signal must come between
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(END_S):
                await process.wait()
    if process.returncode is None:
        await stop(process, END_S)
    reason = said.get("error") or f"it exited at once; the end of its log: {_tail(log)}"
    if python is not None:
        fault = await fault_of(python, spoke="ready" in said)
        reason = f"{fault}; {reason}" if fault is not None else reason
    failed = ServerFailed(f"the device server did not start: {reason}")
    failed.again = bool(said.get("again"))
    raise failed


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
    """The server that still serves this folder, if one responds."""
    try:
        words = json.loads((folder / FILE).read_bytes())
        left = _Left(
            words["pid"], words["url"], words["devices"], words["settings"], words.get("owner")
        )
        client = DeviceClient(left.url, token)
        try:
            # The boot distinguishes our server from another one that has since got the same port.
            found = await client.open(GREETING_S)
        finally:
            await client.close()
    except (OSError, ValueError, KeyError, ServerUnreachable):
        return None
    return left if found.boot == words["boot"] else None
