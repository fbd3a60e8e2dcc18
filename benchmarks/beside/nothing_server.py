"""A device server as a run would start it, or one whose ledger does not wait for the disk.

The product has no such switch: a ledger that may forget would break its promise. Either server also
answers `exchange`: the messages of an action, and no action.
Run: python nothing_server.py SETTINGS.json [--unsynced]
"""

import sqlite3
import sys
from typing import Any

from labrun.drivers.server import host
from labrun.drivers.server.ledger import Ledger
from labrun.drivers.server.serve import main
from labrun.drivers.server.server import DeviceServer
from labrun.schemas.messages import NAMESPACE


class UnsyncedLedger(Ledger):
    """The same writes in the same order; when they reach the disk is left to the system."""

    def _open(self) -> sqlite3.Connection:
        disk = super()._open()
        disk.execute("PRAGMA synchronous = OFF")
        return disk


class TalkingServer(DeviceServer):
    """Answers as it does to a goal, and tells everybody that it has ended."""

    def _listen(self) -> None:
        super()._listen()
        self._sio.on("exchange", self._exchange, namespace=NAMESPACE)

    async def _exchange(self, session: str, goal: dict[str, Any]) -> dict[str, Any]:
        boot, mark, seq = self.ledger.boot, self.ledger.mark, goal["epoch"]
        told = {"id": goal["id"], "state": "SUCCEEDED", "seq": seq, "boot": boot, "result": {}}
        self.tell("update", told, set())
        return {"ok": True, "id": goal["id"], "state": "EXECUTING", "seq": seq, "mark": mark}


if __name__ == "__main__":
    if "--unsynced" in sys.argv[2:]:
        host.Ledger = UnsyncedLedger
    host.DeviceServer = TalkingServer
    sys.exit(main(sys.argv[1:2]))
