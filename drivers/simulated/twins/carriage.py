"""A gantry's position: what its controller believes, and the truth."""

from ...world import World
from .axis import Point, Steps, to_mm, to_steps


class Carriage:
    """Positions in whole steps, published to the world whenever they change.

    `slip` is how much further the carriage truly is than the controller believes: steps that were
    lost. Only homing finds them again.
    """

    def __init__(self, world: World, name: str, homed: bool) -> None:
        self.world = world
        self.name = name
        self.homed = homed
        self.steps: Steps = (0, 0, to_steps((0, 0, 100))[2])
        self.slip: Steps = (0, 0, 0)
        self.zero: Steps = (0, 0, 0)  # where the work zero is, in believed steps

    def recall(self) -> None:
        """Start where an earlier process left it."""
        if found := self.world.look(self.name):
            self.steps, self.slip = _three(found["steps"]), _three(found["slip"])
            self.homed = found["homed"]
            self.zero = _three(found.get("zero", self.zero))
        self.publish()

    def publish(self) -> None:
        """Publish the true position to the world, and store the rest for a restart after a kill."""
        place = dict(zip("xyz", to_mm(self.true), strict=True))
        memory = {"steps": self.steps, "slip": self.slip, "homed": self.homed}
        self.world.publish(self.name, place | memory | {"zero": self.zero})

    def find_switches(self) -> None:
        """The switches are where they are, whatever the controller believes."""
        self.steps, self.slip = self.true, (0, 0, 0)

    @property
    def true(self) -> Steps:
        x, y, z = (a + b for a, b in zip(self.steps, self.slip, strict=True))
        return x, y, z

    @property
    def believed_mm(self) -> Point:
        return to_mm(self.steps)

    def words(self) -> str:
        """The believed position for people to read."""
        x, y, z = self.believed_mm
        return f"x {x:.3f} y {y:.3f} z {z:.3f} mm"


def _three(values: list[int]) -> Steps:
    x, y, z = values
    return x, y, z
