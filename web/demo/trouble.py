"""Trouble to order: an action that fails, a server that dies, one that hangs."""

import os
import signal
import sys
from pathlib import Path

from ..bench.bench import Bench
from ..bench.station import Station
from ..guard.refusal import Refusal
from ..models.demo import OrderFault
from .orders import clear, order

SIGNALS = {"kill": "SIGKILL", "freeze": "SIGSTOP", "thaw": "SIGCONT"}


class Trouble:
    """Acts on the bench of a demonstration; `world` is what its twins share."""

    def __init__(self, bench: Bench, world: Path) -> None:
        self._bench = bench
        self._world = world

    async def order(self, asked: OrderFault) -> str:
        """Do as ordered; a sentence."""
        station = self._bench.station(asked.device)
        if asked.kind == "clear":
            clear(self._world, station.name)
            return f"nothing is ordered of {station.name} any more"
        if asked.kind != "error":
            return self._signal(station, asked.kind)
        if asked.action is None or asked.action not in station.contract.actions:
            known = ", ".join(station.contract.actions)
            raise Refusal(422, "PARAMS", f"{station.name} has no action {asked.action!r}: {known}")
        errors = station.contract.actions[asked.action].errors
        if not errors or (asked.error is not None and asked.error not in errors):
            known = ", ".join(errors) or "none"
            raise Refusal(422, "PARAMS", f"errors of {station.name}.{asked.action}: {known}")
        order(self._world, station.name, asked.action, asked.error, asked.count)
        return f"the next {asked.count} of {station.name}.{asked.action} will fail"

    def _signal(self, station: Station, kind: str) -> str:
        pid = station.server_pid
        if pid is None or sys.platform == "win32":
            raise Refusal(409, "NO_SERVER", f"{station.name} has no server of ours to {kind}")
        try:
            os.kill(pid, getattr(signal, SIGNALS[kind]))
        except ProcessLookupError:
            raise Refusal(409, "NO_SERVER", f"the server of {station.name} is gone") from None
        return f"{kind}: the server of {station.name} (process {pid})"
