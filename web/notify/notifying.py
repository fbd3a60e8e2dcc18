"""See what people want to hear of, and tell each receiver, when it is not quiet."""

import asyncio
from collections.abc import Callable, Iterable
from datetime import UTC, datetime, time
from pathlib import Path

from ...system.tasks import end, keep, spawn
from ..models.devices import DeviceState
from ..models.runs import RunSummary
from ..models.settings import Event, Receiver, Settings
from .deliver import Message, NotDelivered, deliver

LOOK_S = 1.0
AGAIN_S = (5.0, 30.0)
"""Between tries; after the last one it is said that nobody could be told."""
MOST_HELD = 50
FIGURES = ("element_maps.png", "line_scan.png")


class Notifying:
    """Compares the bench with what it was a second ago. `tell` shows what could not be delivered."""

    def __init__(
        self, settings: Callable[[], Settings], runs: Callable[[], Iterable[RunSummary]],
        devices: Callable[[], Iterable[DeviceState]], folder: Path, tell: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._settings, self._runs, self._devices = settings, runs, devices
        self._folder, self._tell = folder, tell
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

    async def test(self, receiver: Receiver, settings: Settings) -> str:
        """Send a test, at any hour; raises NotDelivered."""
        await deliver(
            self._message("test", "This is a test: messages arrive."), receiver, settings.mail
        )
        return f"sent to {receiver.to}"

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
            told = _of_run(self._seen_runs.get(run.id), run)
            if told is not None:
                found.append(self._message(*told, run=run.id))
        self._seen_runs = runs
        reach = {device.name: device.reach for device in self._devices()}
        for name, now in reach.items():
            if now == "lost" and self._seen_reach.get(name) == "online":
                found.append(self._message("device_lost", f"{name} is lost", device=name))
        self._seen_reach = dict(reach)
        return found

    def say(self, message: Message) -> None:
        """Tell those who want to hear of it; in quiet hours it waits for their end."""
        settings = self._settings()
        wanted = [one for one in settings.receivers if message.event in one.events]
        if wanted and is_quiet(settings, datetime.now().time()):
            self._held = [*self._held, message][-MOST_HELD:]
            return
        for receiver in wanted:
            task = spawn("tell a person elsewhere", self._deliver(message, receiver))
            self._sending.add(task)
            task.add_done_callback(self._sending.discard)

    def _release(self) -> None:
        if self._held and not is_quiet(self._settings(), datetime.now().time()):
            held, self._held = self._held, []
            for message in held:
                self.say(message)

    async def _deliver(self, message: Message, receiver: Receiver) -> None:
        why = ""
        for wait_s in (0.0, *self.again_s):
            await asyncio.sleep(wait_s)
            try:
                await deliver(message, receiver, self._settings().mail)
                return
            except NotDelivered as fault:
                why = str(fault)
        self._tell(f"not delivered: “{message.text}” ({why})")

    def _message(self, event: str, text: str, *, run: str = "", device: str = "") -> Message:
        figures = (self._folder / run / name for name in FIGURES) if run else ()
        return Message(
            event=event, text=text, bench=self._settings().bench, run=run, device=device,
            at=datetime.now(UTC).isoformat(timespec="seconds"),
            picture=next((path for path in figures if path.exists()), None),
        )  # fmt: skip


def _of_run(before: RunSummary | None, now: RunSummary) -> tuple[Event, str] | None:
    """The event of a run that was in one state and is in another, and its sentence."""
    if now.questions > (before.questions if before is not None else 0) and now.live:
        return "question", f"{now.protocol} is waiting for you: {now.now}"
    if before is None or not before.live or now.live:
        return None
    if now.fate == "succeeded":
        return "done", f"{now.protocol} is done: {now.word}"
    return (
        "failed",
        f"{now.protocol} {now.word or now.fate}{f': {now.reason}' if now.reason else ''}",
    )


def is_quiet(settings: Settings, now: time) -> bool:
    """True between the hours in which nobody wants to hear; they may go over midnight."""
    if not settings.quiet_from or not settings.quiet_to:
        return False
    begin, over = time.fromisoformat(settings.quiet_from), time.fromisoformat(settings.quiet_to)
    return begin <= now < over if begin <= over else now >= begin or now < over
