"""Messages to people: what a protocol's `notify` says, and what the lab wants told of every run.

Sent by Apprise (mail, Slack, Teams, ntfy, webhooks) to the addresses in the lab. The run depends on none of
them: one that does not get through is a line on the screen.
"""

import asyncio
import os
from pathlib import Path

from ...schemas.event import Event
from ...schemas.journal import ended_as
from ...schemas.lab import LabNotify
from ...system.extras import not_installed
from ...system.tasks import spawn
from ..run.run import Run

END_S = 15.0
"""How long the end of a run waits for messages that are under way."""


class Notifier:
    """Sends to the lab's addresses, each message in a thread of its own."""

    def __init__(self, run: Run, wanted: LabNotify) -> None:
        self.run, self.wanted = run, wanted
        self._tasks: set[asyncio.Task[None]] = set()

    def send(self, text: str, picture: str = "") -> None:
        """Send a message, with a picture from the run's folder."""
        task = spawn("notify", self._send(text, picture))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def hear(self, event: Event) -> None:
        """What happens in the run, of which the lab wants to be told."""
        if event.event == "question" and event.state == "open" and "question" in self.wanted.on:
            self.send(f"a question is open: {event.text}")
        elif event.event == "finished":
            done = event.state == "succeeded"
            if ("done" if done else "failed") in self.wanted.on:
                ended = ended_as(event.state, int(event.data.get("holes") or 0))
                self.send(f"{ended}: {event.text}" if event.text else ended)

    async def close(self) -> None:
        """Wait for messages that are under way, not for ever."""
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=END_S)

    async def _send(self, text: str, picture: str) -> None:
        path = self.run.folder / picture if picture else None
        try:
            why_not = await asyncio.to_thread(_apprise, self.wanted.to, self.run.id, text, path)
        except ImportError as fault:
            why_not = not_installed(fault) or str(fault)
        except Exception as fault:  # of any of a hundred services
            why_not = f"{type(fault).__name__}: {fault}"
        if why_not:
            self.run.log(f"nobody was told {text!r}: {why_not}")


def _apprise(addresses: list[str], title: str, text: str, picture: Path | None) -> str:
    """Send to each address; why it did not get through, or nothing."""
    import apprise  # pyright: ignore[reportMissingImports]

    sender = apprise.Apprise()
    for said in addresses:
        address = os.environ.get(said[1:], "") if said.startswith("$") else said
        if not address or not sender.add(address):
            return f"{said.partition(':')[0]} is not an address that Apprise knows"
    attach = str(picture) if picture is not None and picture.is_file() else None
    sent = sender.notify(body=text, title=title, attach=attach)
    return "" if sent else "not every address took the message"
