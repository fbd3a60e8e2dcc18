"""A device for tests: `script: "Broken,ok"` says how each call under one name ends.

Words: `ok`, an error's name, `happened!` (took effect, then an unknown error), `hang` (waits
until it is cancelled), `held` (waits for a file NAME.go beside its log). What it was asked stands
in that log.
"""

import asyncio
import json

from labrun.drivers.driver import ActionCanceled, ActionFailed, Driver


class Scripted(Driver):
    contract = "scripted@1"

    async def open(self):
        self.calls = {}
        self.newest = {"n": 0, "name": "", "goal_id": None}
        self.log = self.place.world / "calls.jsonl"
        self.level = 0.0

    async def _do(self, action, goal, name="", script="ok", seconds=0.0, x=0.0):
        key = (goal.id.partition("/")[0], name)
        self.calls[key] = n = self.calls.get(key, 0) + 1
        words = script.split(",")
        word = words[min(n, len(words)) - 1]
        self._note(goal, action, name, word)
        if seconds or word == "hang":
            goal.feedback(message="under way")
        if seconds:
            await self._last(goal, action, seconds)
        if word == "hang":
            await goal.cancelled.wait()
            raise ActionCanceled
        if word == "held":
            while not self.log.with_name(f"{name}.go").exists():  # noqa: ASYNC110 (a process apart)
                await asyncio.sleep(0.01)
            word = "ok"
        if word == "happened!":
            self.newest = {"n": n, "name": name, "goal_id": goal.id}
            raise ActionFailed("Foggy", "nobody saw it")
        if word != "ok":
            raise ActionFailed(word, f"scripted {word}")
        self.newest = {"n": n, "name": name, "goal_id": goal.id}
        self._note(goal, action, name, "done")
        return {"n": n, "name": name, "x": x}

    async def _last(self, goal, action, seconds):
        waiting = asyncio.ensure_future(goal.cancelled.wait())
        done, _ = await asyncio.wait([waiting], timeout=seconds)
        waiting.cancel()
        if done and action == "act":
            raise ActionCanceled

    def _note(self, goal, action, name, word):
        line = {
            "run": goal.id.partition("/")[0], "goal": goal.id.partition("/")[2],
            "device": self.place.device, "action": action, "name": name, "word": word,
        }  # fmt: skip
        with self.log.open("a") as file:
            file.write(json.dumps(line) + "\n")

    async def act(self, goal, *, name="", script="ok", seconds=0.0, x=0.0):
        return await self._do("act", goal, name, script, seconds, x)

    async def tune(self, goal, *, name="", script="ok", seconds=0.0, x=0.0):
        return await self._do("tune", goal, name, script, seconds, x)

    async def shoot(self, goal, *, name="", script="ok", seconds=0.0, x=0.0):
        return await self._do("shoot", goal, name, script, seconds, x)

    async def pulse(self, goal, *, name="", script="ok", seconds=0.0, x=0.0):
        return await self._do("pulse", goal, name, script, seconds, x)

    async def last(self, goal):
        return dict(self.newest)

    async def show(self, goal, *, name="", level=0.0):
        self.level = level
        self._note(goal, "show", name, "done")
        return {}

    async def read(self, goal):
        if self.level < 0:
            raise ActionFailed("Broken", "its sensor does not answer")
        return {"level": self.level}

    async def status(self):
        if self.level < 0:
            raise OSError("its sensor does not answer")
        return {"level": self.level}

    async def rest(self, goal):
        return {}

    async def safe(self):
        with self.log.open("a") as file:
            file.write(json.dumps({"device": self.place.device, "action": "safe"}) + "\n")
