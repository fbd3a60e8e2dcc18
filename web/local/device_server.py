"""The server of one device: started here at its port, or already listening there, and greeted."""

import asyncio
import os
from pathlib import Path

from ...drivers.client.client import DeviceClient, ServerUnreachable
from ...drivers.client.launch import RunningServer, start_server
from ...engine.dispatch.connect import IDLE_EXIT_S, server_config
from ...engine.dispatch.served_lab import listens, live_servers
from ...engine.lab.lab import LoadedLab
from ...schemas.messages import ServerDescription


async def serve_here(name: str, lab: LoadedLab, folder: Path) -> tuple[str, RunningServer | None]:
    """Its address, and the process if started here; raises ServerFailed, OSError."""
    device = lab.lab.devices[name]
    port = device.port
    assert port is not None, "lab_here gives one to every device with a driver"
    own = folder / name
    if not any(live_servers(own)) and await asyncio.to_thread(listens, port):
        return f"http://127.0.0.1:{port}", None  # served from another shell
    config = server_config({name: device}, lab, folder)
    config.update(port=port, idle_exit_s=IDLE_EXIT_S, owner_pid=os.getpid())
    server = await start_server(config, own, timeout_s=lab.lab.start_timeout_s)
    return server.url, server


async def greet(
    client: DeviceClient, url: str, name: str, contract: str, timeout_s: float
) -> ServerDescription:
    """Open the client; if another device is served, close it and raise ServerUnreachable."""
    try:
        described = await client.open(timeout_s)
        if name not in described.devices:
            served = ", ".join(described.devices) or "nothing"
            raise ServerUnreachable(url, f"it serves {served}, not {name}")
        kept = described.devices[name].contract.get("type")
        if kept != contract:
            raise ServerUnreachable(url, f"it implements {kept}, not {contract}")
    except BaseException:  # raised again: nobody else would close the client
        await client.close()
        raise
    return described
