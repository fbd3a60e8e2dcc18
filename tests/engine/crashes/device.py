"""A device for crashes: its memory is a file, its faults depend on nothing but its script.

`word` is how the action ends in the first `tries` attempts that were begun at its path (one that was
announced and never sent is none) and throughout its first `turns` turns (of a group's retry, of an
`ask: repeat`); then it succeeds, also where it is done for an iteration that is over. Words beside the
contract's errors:
`happened!` and `dark` (a Foggy end, with and without effect), `die+` and `die-` (the server kills
itself, with and without effect).
"""

import asyncio
import json
import os
import re
import signal
from pathlib import Path

from labrun.drivers.driver import ActionCanceled, ActionFailed, Driver

LEVEL = re.compile(r"[ar](\d+)")
WITHOUT_EFFECT = ("Broken", "dark", "die-")


class Bench(Driver):
    """What happens is recorded with one write, at the instant it happens."""

    contract = "bench@1"

    async def open(self):
        self.log = self.place.world / "happened.jsonl"
        self._put(None)

    async def set(self, goal, **asked):
        return await self._do("set", goal, **asked)

    async def shoot(self, goal, **asked):
        return await self._do("shoot", goal, **asked)

    async def look(self, goal, **asked):
        return await self._do("look", goal, **asked)

    async def last(self, goal):
        """The newest shot of this run: a run begins with a device that remembers nothing."""
        mine = [line for line in self._lines() if line["device"] == self.place.device]
        shots = [s for s in mine if s["action"] == "shoot" and s["run"] == _run(goal.id)]
        newest = shots[-1] if shots else {"name": None, "goal": None}
        return {"name": newest["name"], "goal_id": newest["goal"]}

    async def rest(self, goal):
        await self.safe()
        return {}

    async def safe(self):
        self._put(None)

    async def _do(self, action, goal, name="", word="ok", tries=0, turns=0, ms=0.0, to=0.0):
        self._note(goal.id, "begin", name)
        faulty = self._begun(goal.id) <= tries or _turn(goal.id) <= turns
        word = word if faulty and ":again:" not in goal.id else "ok"
        await self._pass(goal, ms / 1000, action)
        if word not in WITHOUT_EFFECT:
            if action == "set":
                self._put(to)
            self._note(goal.id, action, name)
        if word.startswith("die"):
            os.kill(os.getpid(), signal.SIGKILL)
        if word != "ok":
            error = word if word in ("Broken", "Half") else "Foggy"
            raise ActionFailed(error, f"as the script says: {word}")
        return {"name": name}

    async def _pass(self, goal, seconds, action):
        waiting = asyncio.ensure_future(goal.cancelled.wait())
        done, _ = await asyncio.wait([waiting], timeout=seconds)
        waiting.cancel()
        if done and action != "shoot":
            raise ActionCanceled

    def _put(self, value):
        """The state of one device, where the others see it: a shot notes all of them."""
        (self.place.world / f"{self.place.device}.state").write_text(json.dumps(value))

    def _states(self):
        states = self.place.world.glob("*.state")
        return {path.stem: json.loads(path.read_text()) for path in states}

    def _note(self, goal_id, action, name):
        line = {
            "run": _run(goal_id), "goal": goal_id, "device": self.place.device,
            "action": action, "name": name, "states": self._states(),
            "announced": self._announced(goal_id),
        }  # fmt: skip
        file = os.open(self.log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        os.write(file, json.dumps(line).encode() + b"\n")
        os.close(file)

    def _announced(self, goal_id):
        """Whether the run's journal, on disk, speaks of this goal already."""
        journal = Path(self.place.config["runs"]) / _run(goal_id) / "journal.jsonl"
        return f'"kind":"goal","id":"{goal_id}"' in journal.read_text(errors="replace")

    def _begun(self, goal_id):
        """How many attempts were begun where this one is."""
        path = re.escape(goal_id.rpartition("/")[0])
        begun = rf'"goal": "{path}/\d+", "device": "\w", "action": "begin"'
        return len(re.findall(begun, self.log.read_text()))

    def _lines(self):
        return [json.loads(line) for line in self.log.read_text().splitlines()]


class Bare(Bench):
    contract = "bare@1"


def _run(goal_id):
    return goal_id.partition("/")[0]


def _turn(goal_id):
    levels = [LEVEL.fullmatch(part) for part in goal_id.split("/")[:-1]]
    return 1 + sum(int(level[1]) - 1 for level in levels if level)
