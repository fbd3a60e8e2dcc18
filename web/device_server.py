"""The server of one device: started here at its port, or one that listens there already, and greeted."""

import asyncio
import os
from pathlib import Path

from ..drivers.client import DeviceClient, ServerUnreachable
from ..drivers.launch import RunningServer, start_server
from ..engine.connect import IDLE_EXIT_S, listens, server_config
from ..engine.lab import LoadedLab
from ..schemas.messages import ServerDescription

GREETING_S = 5.0


async def serve_here(name: str, lab: LoadedLab, folder: Path) -> tuple[str, RunningServer | None]:
    """Its address, and the process if it is ours; raises ServerFailed, OSError."""
    device = lab.lab.devices[name]
    port = device.port
    assert port is not None, "lab_here gives one to every device with a driver"
    own = folder / name
    if not own.is_dir() and await asyncio.to_thread(listens, port):
        return f"http://127.0.0.1:{port}", None  # somebody serves it in another shell
    config = server_config({name: device}, lab, folder)
    config.update(port=port, idle_exit_s=IDLE_EXIT_S, owner_pid=os.getpid())
    server = await start_server(config, own)
    return server.url, server


async def greet(client: DeviceClient, url: str, name: str, contract: str) -> ServerDescription:
    """Open the client; it is closed and ServerUnreachable raised where another device is served."""
    try:
        described = await client.open(GREETING_S)
        if name not in described.devices:
            served = ", ".join(described.devices) or "nothing"
            raise ServerUnreachable(url, f"it serves {served}, not {name}")
        kept = described.devices[name].contract.get("type")
        if kept != contract:
            raise ServerUnreachable(url, f"it keeps {kept}, not {contract}")
    except BaseException:
        await client.close()
        raise
    return described
