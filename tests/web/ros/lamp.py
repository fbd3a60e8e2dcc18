"""A lamp that does everything a ROS client may be curious about."""

import asyncio

from labrun.drivers.driver import ActionCanceled, ActionFailed, Driver


class Lamp(Driver):
    """Glows, flashes, and burns out when it is told `#fff`."""

    contract = "lamp@1"
    lit = False

    async def status(self):
        return {
            "lit": self.lit, "colour": "warm white", "levels": [1.5, 2.25], "counts": [1, 2**40],
            "place": {"x": 3.5, "class": "A"}, "note": None, "more": {"a": [1, None]},
        }  # fmt: skip

    async def glow(self, goal, *, seconds, colour="red", pattern=None, extra=None):
        if colour == "#fff":
            raise ActionFailed("Burnt", "too bright for this bulb")
        goal.feedback(0.0, f"glowing {colour}")
        self.lit = True
        try:
            async with asyncio.timeout(seconds):
                await goal.cancelled.wait()
        except TimeoutError:
            goal.feedback(1.0, "done")
            return {"seconds": seconds, "pattern": pattern or [], "extra": extra}
        finally:
            self.lit = False
        raise ActionCanceled

    async def flash(self, goal):
        return {}

    async def age(self, goal, *, of="bulb"):
        if of == "nothing":
            raise ActionFailed("Unknown", "nobody knows")
        return {"hours": None if of == "bulb" else 12.5, "of": of}

    async def beacon(self, goal):
        goal.feedback(None, "turning")
        await asyncio.sleep(600)
        return {}
