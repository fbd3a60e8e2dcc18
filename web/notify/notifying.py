"""Tell people what no engine can: that a device is lost, that an engine is gone, and what had to wait.

Of its run an engine tells itself, whether or not anybody has the page.
"""

import asyncio
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ...drivers.messenger.sending import AGAIN_S, deliver, reasons
from ...engine.runner.notify import HELD
from ...schemas.lab import LabNotify, NotifyEvent
from ...system.files import remove
from ...system.tasks import end, keep, spawn
from ..models.devices import DeviceState
from ..models.runs import RunSummary

LOOK_S = 1.0
MOST_HELD = 50


class NotDelivered(Exception):
    """The text says what refused it."""


@dataclass(frozen=True, slots=True)
class Message:
    """What happened, for people; without an `event` it is for everybody."""

    event: NotifyEvent | None
    text: str
    about: str
    picture: Path | None = None


class Notifying:
    """Compares the bench with what it was a second ago. `tell` shows what could not be delivered."""

    def __init__(
        self, notify: Callable[[], LabNotify | None], runs: Callable[[], Iterable[RunSummary]],
        devices: Callable[[], Iterable[DeviceState]], folder: Path, tell: Callable[[str], None],
        bench: Callable[[], str],
    ) -> None:  # fmt: skip
        self._notify, self._runs, self._devices = notify, runs, devices
        self._folder, self._tell, self._bench = folder, tell, bench
        self._seen_runs: dict[str, RunSummary] = {}
        self._seen_reach: dict[str, str] = {}
        self._held: list[Message] = []
        self._sending: set[asyncio.Task[None]] = set()
        self._looking: asyncio.Task[None] | None = None
        self.again_s = AGAIN_S

    def open(self) -> None:
        """Begin to look."""
        self._looking = keep("see what people want to hear of", self._look)

    async def close(self) -> None:
        """Stop looking; what is on its way is dropped."""
        await end(self._looking)
        for task in list(self._sending):
            await end(task)

    async def test(self, address: str) -> str:
        """Send a test, at any hour; raises NotDelivered."""
        text = "This is a test: messages arrive."
        if refused := await deliver([address], self._bench(), text, again_s=(0.0,)):
            raise NotDelivered(reasons(refused))
        return f"sent to {address.partition(':')[0]}"

    async def _look(self) -> None:
        self.events()  # what is there already is not news
        while True:
            await asyncio.sleep(LOOK_S)
            for message in self.events():
                self.say(message)
            self._release()

    def events(self) -> list[Message]:
        """What has happened since it was called before."""
        found: list[Message] = []
        runs = {run.id: run for run in self._runs()}
        for run in runs.values():
            before = self._seen_runs.get(run.id)
            if before is not None and before.live and not run.live:
                found += self._of_end(run)
        self._seen_runs = runs
        reach = {device.name: device.reach for device in self._devices()}
        for name, now in reach.items():
            if now == "lost" and self._seen_reach.get(name) == "online":
                found.append(Message("device_lost", f"{name} is lost", self._bench()))
        self._seen_reach = dict(reach)
        return found

    def _of_end(self, run: RunSummary) -> Iterable[Message]:
        """That its engine is gone without an end, and what it could tell nobody in quiet hours."""
        if run.fate == "interrupted":
            yield Message("failed", f"{run.protocol}: its engine is gone; `labrun resume`", run.id)
        path = self._folder / run.id / HELD
        try:
            held = json.loads(path.read_bytes())
            remove(path)
        except (OSError, ValueError):
            return
        for one in held:
            if "lost" in one:
                self._tell(f"{run.id}: {one['lost']}")
            else:
                picture = path.parent / one["picture"] if one.get("picture") else None
                yield Message(one["event"], one["text"], run.id, picture)

    def say(self, message: Message) -> None:
        """Tell those who want to hear of it; in quiet hours it waits for their end."""
        notify = self._notify()
        told = notify.addresses(message.event) if notify is not None else []
        if notify is not None and told and notify.is_quiet(datetime.now().time()):
            self._held = [*self._held, message][-MOST_HELD:]
        elif told:
            spawn("tell a person elsewhere", self._deliver(message, told), among=self._sending)

    def _release(self) -> None:
        notify = self._notify()
        if self._held and not (notify is not None and notify.is_quiet(datetime.now().time())):
            held, self._held = self._held, []
            for message in held:
                self.say(message)

    async def _deliver(self, message: Message, told: list[str]) -> None:
        refused = await deliver(
            told, message.about, message.text, message.picture, again_s=self.again_s
        )
        if refused:
            self._tell(f"not delivered: “{message.text}” ({reasons(refused)})")
