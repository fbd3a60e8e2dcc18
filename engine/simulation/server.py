"""A device server in the simulation: killed, ended in order, and started again, on a disk that stays."""

import asyncio
import contextlib
from pathlib import Path
from random import Random
from typing import Any

from ...drivers.server.device import ServedDevice
from ...drivers.server.server import DeviceServer
from ...schemas import journal as j
from ..journal.journal import JournalFault, read_records
from .disk import Disk, OnDisk, SimulatedLedger
from .instrument import Instrument, driver_of, place_of
from .wire import Network, Socket

DOWN_S = 0.05, 5.0


class SimulatedServer:
    """Serves one instrument at `url`, in one process after another."""

    def __init__(
        self, instrument: Instrument, network: Network, random: Random, journal: Path
    ) -> None:
        self.instrument, self.network, self.random = instrument, network, random
        self.url = f"http://{instrument.name}"
        self.disk = Disk()
        self.copies: list[tuple[int, dict[str, bytes], str]] = []
        self.process: OnDisk | None = None
        self.server: DeviceServer | None = None
        self.loses_ledger = False
        self._journal = journal
        self._over = asyncio.Event()

    async def live(self) -> None:
        """Serve, and be started again, for ever."""
        while True:
            self._over.clear()
            self.process = OnDisk(self.disk)
            serving = self.process.spawn(f"serve {self.instrument.name}", self._serve())
            serving.add_done_callback(
                lambda _: self._over.set()
            )  # a full disk keeps it from starting
            try:
                await self._over.wait()
                self.process.kill()
                await asyncio.wait({serving})
                await self.process.bury()
            finally:
                self.process.bury_files()
            self._replace_ledger()
            await asyncio.sleep(self.random.uniform(*DOWN_S))

    async def _serve(self) -> None:
        assert self.process is not None
        ledger = SimulatedLedger(self.random)
        server: Any = DeviceServer(ledger)
        socket = server._sio = Socket(self.process)
        server._listen()
        socket.handlers["connected"] = lambda session: _connected(server, session)
        instrument = self.instrument
        place = place_of(instrument, Path())
        driver = driver_of(instrument)(place)
        device = ServedDevice(place, driver, instrument.contract, ledger, server.tell)
        await server.open([device])
        self.server = server
        self.copy_ledger()  # as a nightly backup has it
        self.network.sockets[self.url] = socket
        await asyncio.Event().wait()

    def kill(self) -> None:
        """SIGKILL."""
        if self.process is not None and self.process.alive:
            self.process.kill()
            self._gone()

    def terminate(self) -> None:
        """SIGTERM: safe first, then the end."""
        if self.process is not None and self.server is not None and self.process.alive:
            self.process.spawn("end in order", self._end(self.server))

    async def _end(self, server: DeviceServer) -> None:
        await server.make_safe()
        self.network.drop(self.url)
        try:
            await server.close()
        finally:
            self.kill()

    def _gone(self) -> None:
        self.server = None
        if self.url in self.network.sockets:
            self.network.drop(self.url)
            del self.network.sockets[self.url]
        self._over.set()

    # --- ledgers that are copied, put back, and lost

    def copy_ledger(self) -> None:
        """Somebody copies its files."""
        if self.server is not None:
            number = _number(self.server.ledger.mark)
            self.copies.append((number, self.disk.copy(), self.instrument.newest))

    def _replace_ledger(self) -> None:
        """At the next start it is an older one, or none, if the journal can know (decision 0027)."""
        if not self.loses_ledger:
            return
        self.loses_ledger = False
        seen: list[int] = []
        with contextlib.suppress(JournalFault, OSError):  # its engine died before the first record
            seen = [
                _number(record.mark)
                for record in read_records(self._journal)
                if isinstance(record, j.Leased | j.Marked) and record.device == self.instrument.name
            ]
        older = [copied[1:] for copied in self.copies if seen and copied[0] < seen[-1]]
        if seen and self.random.random() < 0.3:
            self._put_back({}, "")
        elif older:
            self._put_back(*self.random.choice(older))

    def _put_back(self, files: dict[str, bytes], newest: str) -> None:
        self.disk.put_back(files)
        if self.instrument.beside_ledger:
            self.instrument.newest = newest


async def _connected(server: DeviceServer, session: str) -> None:
    server.sessions.add(session)


def _number(mark: str) -> int:
    return int(mark.split(":")[1])
