"""One study, played with any optimizer's driver: a hidden best place, told as it is asked."""

from pathlib import Path

from labrun.drivers.driver import Driver, GoalContext, Place

from ..played import played as driver_played

SPACE = {
    "x": {"minimum": -2, "maximum": 3},
    "y": {"minimum": 0, "maximum": 1, "step": 0.05},
    "base": {"choices": ["lime", "soda"]},
}
BEST = {"x": 1.2, "y": 0.3, "base": "soda"}


def loss(point: dict) -> float:
    """0 in the best place, and more everywhere else."""
    wrong = point["base"] != BEST["base"]
    return (point["x"] - BEST["x"]) ** 2 + 4 * (point["y"] - BEST["y"]) ** 2 + 0.5 * wrong


def played(kind: type[Driver], folder: Path, story):
    """What a story returns; the same folder again is the same device after a restart."""
    return driver_played(kind(Place("optimizer", {}, {}, folder, folder)), story)


class Asker:
    """Does actions with goals of one run, numbered."""

    def __init__(self, driver, run="run", begin=0):
        self.driver, self.run, self.number = driver, run, begin

    async def do(self, action, **params):
        self.number += 1
        return await getattr(self.driver, action)(
            GoalContext(f"{self.run}/{self.number}"), **params
        )

    async def search(self, turns, n=1):
        for _ in range(turns):
            for point in (await self.do("ask", n=n))["suggestions"]:
                await self.do("tell", at=point, values={"loss": loss(point)})
