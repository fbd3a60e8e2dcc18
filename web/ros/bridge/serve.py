"""Listen, admit clients through the gate, serve each until it disconnects."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

from websockets.asyncio.server import ServerConnection, serve
from websockets.typing import Subprotocol

from ..offers.goals import Goals
from ..offers.offer import Offers
from .client import Client
from .frames import MOST_BYTES
from .gate import Gate
from .operations import OPERATIONS
from .rooms import Rooms

PING_S = 20.0
CLOSE_S = 2.0
SUBPROTOCOL = Subprotocol("rosbridge_v2")


@asynccontextmanager
async def bridge(offers: Offers, goals: Goals, gate: Gate, port: int) -> AsyncIterator[str]:
    """The endpoint's address, while the block runs; raises OSError if the port is in use."""
    rooms = Rooms(offers, goals)

    async def serve_client(socket: ServerConnection) -> None:
        await Client(socket, rooms).serve_until_gone(OPERATIONS)

    async with serve(
        serve_client, gate.host, port, process_request=gate.check, max_size=MOST_BYTES, compression=None,
        ping_interval=PING_S, ping_timeout=PING_S, close_timeout=CLOSE_S,
        subprotocols=[SUBPROTOCOL], select_subprotocol=_subprotocol,
    ) as server:  # fmt: skip
        host, bound = next(iter(server.sockets)).getsockname()[:2]
        yield f"ws://{f'[{host}]' if ':' in host else host}:{bound}"


async def ask_for(host: str, port: int) -> None:
    """Raise OSError if the port is not free; called before any device is started."""
    probe = await asyncio.get_running_loop().create_server(asyncio.Protocol, host, port)
    probe.close()
    await probe.wait_closed()


def _subprotocol(
    connection: ServerConnection, offered: Sequence[Subprotocol]
) -> Subprotocol | None:
    """A subprotocol is accepted if a client names one; most do not."""
    return SUBPROTOCOL if SUBPROTOCOL in offered else None
