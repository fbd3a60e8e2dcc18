"""A messenger that takes its time, and tells only a file: it can be caught in the middle."""

import asyncio
import json
from dataclasses import replace

from labrun.drivers.driver import Place
from labrun.drivers.messenger import messenger
from labrun.drivers.messenger.messenger import Messenger


class PatientMessenger(Messenger):
    """Waits `pause` seconds, and writes down each goal when it has sent its message."""

    def __init__(self, place: Place) -> None:
        super().__init__(replace(place, config={"to": {"ada": "file://"}}))
        self.pause_s, self.told = float(place.config.get("pause", 0)), place.folder / "told"
        messenger.deliver = self._deliver

    async def _deliver(self, addresses, title, text, picture=None):
        await asyncio.sleep(self.pause_s)
        with self.told.open("a") as told:
            told.write(f"{json.loads(self._newest.read_bytes())['goal']}\n")
        return {}
