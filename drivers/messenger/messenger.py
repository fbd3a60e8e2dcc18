"""Tells people something as one step of a protocol, through the services that Apprise knows.

What was begun is on disk before it is sent. After a crash in the middle nobody can say whether a service has
taken it; then the probe says so, and the protocol decides (`on_unknown: repeat`: rather twice than never).
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from ...system.files import remove, write_whole
from ..driver import ActionFailed, Driver, GoalContext, Place, check_keys
from .sending import deliver, reasons


class Messenger(Driver):
    """Implements messenger@1.

    Configuration: `to`, name -> address as Apprise has it (or `$NAME`, or with `{FILE}` in it).
    """

    contract: ClassVar[str] = "messenger@1"
    extra: ClassVar[str | None] = "notify"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.to = receivers(place)
        self._newest = place.folder / "newest_message.json"

    async def status(self) -> dict[str, Any]:
        return {"receivers": list(self.to)}

    async def send(
        self, goal: GoalContext, *, text: str, title: str = "", to: list[str] | None = None,
        picture: str | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        told = named(self.to, to)
        file = self._picture(goal, picture)
        self._keep(goal.id, None)
        try:
            addresses = list(dict.fromkeys(told.values()))
            refused = await deliver(addresses, title or goal.id.partition("/")[0], text, file)
        finally:
            if file is not None:
                remove(file)
        reached = [name for name, address in told.items() if address not in refused]
        self._keep(goal.id, reached)
        if refused:
            missed = ", ".join(name for name in told if name not in reached)
            name = "PartlyDelivered" if reached else "NotDelivered"
            raise ActionFailed(name, f"not to {missed}: {reasons(refused)}")
        return {"told": reached}

    async def last_send(self, goal: GoalContext) -> dict[str, Any]:
        try:
            newest = json.loads(self._newest.read_bytes())
        except FileNotFoundError:
            return {"goal_id": ""}
        except ValueError:  # a damaged file proves nothing
            return {"goal_id": None}
        told = newest["told"]
        return {"goal_id": None} if told is None else {"goal_id": newest["goal"], "told": told}

    def _keep(self, goal: str, told: list[str] | None) -> None:
        write_whole(self._newest, json.dumps({"goal": goal, "told": told}).encode())

    def _picture(self, goal: GoalContext, picture: str | None) -> Path | None:
        """The file that came with the goal, where the services can read it; under its own name."""
        sent = goal.files.get("picture")
        if sent is None or picture is None:
            return None
        path = self.place.folder / "sending" / Path(picture).name
        write_whole(path, sent.data, sync=False)
        return path


def receivers(place: Place) -> dict[str, str]:
    """Name -> address from a lab's config; raises ValueError with a sentence."""
    to = place.config.get("to")
    check_keys(("to",), place.config)
    if not isinstance(to, dict) or not to or not all(isinstance(a, str) for a in to.values()):
        raise ValueError(
            "config needs `to`, names with their addresses: "
            'to: {ada: "mailto://...", everybody: "ntfy://our-lab"}'
        )
    return to


def named(to: Mapping[str, str], wanted: list[str] | None) -> dict[str, str]:
    """Those who are to be told; raises ActionFailed for a name that the lab does not have."""
    if unknown := sorted(set(wanted or ()) - set(to)):
        names = ", ".join(to)
        raise ActionFailed("NobodyOfThatName", f"no {', '.join(unknown)}; the lab has {names}")
    return {name: to[name] for name in wanted or to}
