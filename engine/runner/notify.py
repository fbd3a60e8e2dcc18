"""Messages to people: what a protocol's `notify` says, and what the lab wants told of every run.

Sent by Apprise (mail, Slack, Teams, ntfy, webhooks) to the addresses in the lab. The run depends on none of
them: one that does not get through is a line on the screen. In quiet hours messages wait for the end of
these, or of the run; what is left then is in the run's folder, for the page's server to tell.
"""

import asyncio
import json
from datetime import datetime

from ...drivers.messenger.sending import AGAIN_S, deliver, reasons
from ...schemas.event import Event
from ...schemas.journal import ended_as
from ...schemas.lab import LabNotify, NotifyEvent
from ...system.files import write_whole
from ...system.tasks import end, spawn
from ..run.run import Run

END_S = 15.0
"""How long the end of a run waits for messages that are under way."""
LOOK_S = 30.0
"""How often it is seen whether quiet hours are over."""
HELD = "messages.json"
"""In the run's folder: what nobody was told, since its end came in quiet hours, and what did not arrive."""


class Notifier:
    """Sends to the lab's addresses what happens in one run."""

    def __init__(self, run: Run, wanted: LabNotify) -> None:
        self.run, self.wanted = run, wanted
        self._tasks: set[asyncio.Task[None]] = set()
        self._held: list[tuple[NotifyEvent | None, str, str]] = []
        self._lost: list[str] = []
        self._waking: asyncio.Task[None] | None = None

    def send(self, text: str, picture: str = "", event: NotifyEvent | None = None) -> None:
        """Tell those who want to hear of an event, or all, with a picture from the run's folder."""
        if self.wanted.is_quiet(datetime.now().time()):
            self._held.append((event, text, picture))
            self._waking = self._waking or spawn("wait for the end of quiet hours", self._wake())
            return
        spawn("notify", self._send(text, picture, event), among=self._tasks)

    def hear(self, event: Event) -> None:
        """What happens in the run, of which the lab wants to be told."""
        if event.event == "question" and event.state == "open":
            self.send(f"a question is open: {event.text}", event="question")
        elif event.event == "finished":
            ended = ended_as(event.state, int(event.data.get("holes") or 0))
            figures = (name for name in FIGURES if (self.run.folder / name).is_file())
            self.send(
                f"{ended}: {event.text}" if event.text else ended, next(figures, ""),
                "done" if event.state == "succeeded" else "failed",
            )  # fmt: skip

    async def close(self) -> None:
        """Wait for messages that are under way, not for ever; keep what nobody may be told yet."""
        await end(self._waking)
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=END_S)
        await end(*self._tasks)
        if self._held or self._lost:
            held = [
                {"event": event, "text": text, "picture": picture}
                for event, text, picture in self._held
            ]
            data = [*held, *({"lost": words} for words in self._lost)]
            write_whole(self.run.folder / HELD, json.dumps(data).encode(), sync=False)

    async def _wake(self) -> None:
        while self.wanted.is_quiet(datetime.now().time()):  # noqa: ASYNC110 - clocks tell nobody
            await asyncio.sleep(LOOK_S)
        held, self._held, self._waking = self._held, [], None
        for event, text, picture in held:
            self.send(text, picture, event)

    async def _send(self, text: str, picture: str, event: NotifyEvent | None) -> None:
        path = self.run.folder / picture if picture else None
        told = self.wanted.addresses(event)
        if refused := await deliver(told, self.run.id, text, path, again_s=AGAIN_S[:2]):
            who = (
                "nobody was"
                if len(refused) == len(told)
                else f"{len(refused)} of {len(told)} were not"
            )
            self._lost.append(f"{who} told {text!r}: {reasons(refused)}")
            self.run.log(self._lost[-1])


FIGURES = ("element_maps.png", "line_scan.png")
"""The first that there is goes with the news that a run has ended."""
