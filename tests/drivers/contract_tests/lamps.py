"""A lamp that keeps its contract, and lamps that break one promise each."""

import asyncio
import json
import sys

from labrun.drivers.driver import ActionCanceled, Driver, GoalContext


class Lamp(Driver):
    """Flashes are written into the log of the truth, as a twin writes them."""

    contract = "lamp@1"
    lit = False

    @property
    def truth(self):
        path = self.place.world / "truth" / f"{self.place.device}.jsonl"
        path.parent.mkdir(exist_ok=True)
        return path

    async def status(self):
        return {"lit": self.lit}

    async def glow(self, goal: GoalContext, *, seconds: float):
        self.lit = True
        try:
            async with asyncio.timeout(seconds):
                await goal.cancelled.wait()
        except TimeoutError:
            return {"seconds": seconds}
        finally:
            self.lit = False
        raise ActionCanceled

    async def flash(self, goal: GoalContext):
        with self.truth.open("a") as log:
            log.write(json.dumps({"goal": goal.id}) + "\n")
        await asyncio.sleep(2 if self.place.config.get("slow") else 0)
        return {}

    async def last_flash(self, goal: GoalContext):
        lines = self.truth.read_text().splitlines() if self.truth.exists() else []
        return {"goal_id": json.loads(lines[-1])["goal"] if lines else ""}

    async def dark(self, goal: GoalContext):
        self.lit = False
        return {}


class Deaf(Lamp):
    """Does not hear a cancel, and does not let itself be broken off."""

    async def glow(self, goal, *, seconds):
        try:
            await asyncio.sleep(60)
        except asyncio.CancelledError:
            await asyncio.sleep(10)
        return {"seconds": seconds}


class Stubborn(Lamp):
    """Hears a cancel, and says that it succeeded all the same."""

    async def glow(self, goal, *, seconds):
        try:
            return await super().glow(goal, seconds=seconds)
        except ActionCanceled:
            return {"seconds": seconds}


class Babbling(Lamp):
    async def status(self):
        return {"lit": "bright"}


class Mute(Lamp):
    async def status(self):
        raise RuntimeError("no idea")


class Wrong(Lamp):
    async def glow(self, goal, *, seconds):
        return {"seconds": "many"}


class Unsafe(Lamp):
    async def safe(self):
        raise RuntimeError("the switch is worn")


class Glaring(Lamp):
    """Says that it is safe while it still glows."""

    async def safe(self):
        return None

    async def status(self):
        return {"lit": True}


class Forgetful(Lamp):
    """Swears that it never flashed."""

    async def last_flash(self, goal):
        return {"goal_id": ""}


class Dark(Lamp):
    """Says that it flashed, and never did."""

    async def flash(self, goal):
        await asyncio.sleep(2 if self.place.config.get("slow") else 0)
        return {}


class Overtaken(Lamp):
    """Asked at once after a kill, it denies what its instrument is still about to do."""

    INSTRUMENT = """
import pathlib, sys, time
truth, line = pathlib.Path(sys.argv[1]), sys.argv[2]
for _ in range(6000):
    if truth.with_name("go").exists():
        truth.write_text(line)
        break
    time.sleep(0.01)
"""

    async def flash(self, goal):
        line = json.dumps({"goal": goal.id}) + "\n"
        await asyncio.create_subprocess_exec(
            sys.executable, "-c", self.INSTRUMENT, str(self.truth), line, start_new_session=True
        )
        self.truth.with_name("asked").touch()
        await asyncio.sleep(60)
        return {}
