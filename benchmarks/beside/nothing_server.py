"""A device server as a run would start it, or one whose ledger does not wait for the disk.

The product has no such switch: a ledger that may forget would break its promise.
Run: python nothing_server.py SETTINGS.json [--unsynced]
"""

import sqlite3
import sys

from labrun.drivers.server import host
from labrun.drivers.server.ledger import Ledger
from labrun.drivers.server.serve import main


class UnsyncedLedger(Ledger):
    """The same writes in the same order; when they reach the disk is left to the system."""

    def _open(self) -> sqlite3.Connection:
        disk = super()._open()
        disk.execute("PRAGMA synchronous = OFF")
        return disk


if __name__ == "__main__":
    if "--unsynced" in sys.argv[2:]:
        host.Ledger = UnsyncedLedger
    sys.exit(main(sys.argv[1:2]))
