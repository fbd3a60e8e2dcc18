"""Serve devices in a separate process: `python -m labrun.drivers.server.serve SETTINGS.json`.

One JSON line on stdout reports the start, and one each device whose instrument has come into reach
later; all other output goes to stderr.
"""

import asyncio
import contextlib
import json
import logging
import os
import sys
from pathlib import Path
from typing import Any, TextIO

from pydantic import ValidationError

from ...system.start import spare_of_socketio, spare_plugins

if __name__ == "__main__":  # a process of its own, whose start is waited for
    spare_plugins()
    spare_of_socketio("aiohttp")  # for its clients, which few drivers are

from ...schemas.model import first_fault
from ...system.process import alive
from ...system.signals import until_end
from .host import ServeFault, serving
from .ledger import LedgerInUse
from .server import DeviceClosed, DeviceServer
from .server_file import ServerFile
from .settings import ServerSettings

__all__ = ["ServeFault", "main", "read_settings", "serve", "serving"]

LOG = logging.getLogger("labrun")
NOT_STARTED = 4
LOOK_S = 1.0
"""Whether anybody still needs it: an owner that was killed cannot say so."""


def read_settings(path: Path) -> ServerSettings:
    """Settings from a JSON file; raises ServeFault with the first error in it."""
    try:
        return ServerSettings.model_validate(json.loads(path.read_bytes()))
    except (OSError, ValueError) as fault:
        words = first_fault(fault) if isinstance(fault, ValidationError) else str(fault)
        raise ServeFault(f"settings {path}: {words}") from fault


async def serve(settings: ServerSettings, tell: TextIO | None = None) -> None:
    """Serve until a signal comes or the server is no longer needed; `tell` hears where."""
    ended = until_end()
    async with serving(settings) as (server, url):
        present = ServerFile(settings, server.ledger.boot, url)
        present.announce()
        try:
            closed = {name: device.status["fault"] for name, device in server.closed.items()}
            server.on_opened = lambda name: say({"opened": name}, tell)
            say(
                {"ready": True, "url": url, "boot": server.ledger.boot,
                 "devices": list(settings.devices), "closed": closed}, tell,
            )  # fmt: skip
            await _until_needless(server, settings, ended)
        finally:
            present.leave()


async def _until_needless(
    server: DeviceServer, settings: ServerSettings, ended: asyncio.Event
) -> None:
    clock = asyncio.get_running_loop().time
    needed_at = clock()
    while not ended.is_set():
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LOOK_S):
                await ended.wait()
        if not (owned := alive(settings.owner_pid)) and settings.ends_with_owner and server.idle:
            return
        if server.idle and (said := server.ledger.taken_away()):
            LOG.warning("%s. It ends.", said)
            return
        if not server.calm or owned:
            needed_at = clock()
        elif settings.idle_exit_s is not None and clock() - needed_at >= settings.idle_exit_s:
            return


def say(line: dict[str, Any], tell: TextIO | None) -> None:
    """A line on stdout."""
    print(json.dumps(line), file=tell, flush=True)


def own_stdout() -> TextIO:
    """This process's stdout, for its own lines alone.

    What a driver prints goes to stderr from now on, and a program that a driver starts does not
    have the pipe: as long as one has it, a reader does not see that the server has died.
    """
    own = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return own


def main(arguments: list[str], tell: TextIO | None = None) -> int:
    """Exit status: 0 after an orderly end, 4 where the server could not start."""
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING)
    try:
        if len(arguments) != 1:
            raise ServeFault("usage: python -m labrun.drivers.server.serve SETTINGS.json")
        asyncio.run(serve(read_settings(Path(arguments[0])), tell))
    except ServeFault as fault:
        # The hardware may answer the next time, or an older server have ended.
        again = isinstance(fault.__cause__, DeviceClosed | LedgerInUse)
        say({"ready": False, "error": str(fault), "again": again}, tell)
        return NOT_STARTED
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:], own_stdout()))
