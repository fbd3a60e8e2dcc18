"""Straight motion of stepped axes: accelerate, travel at constant speed, decelerate.

The figures are those of a LEAD 1010 machine: 199.1 steps a millimetre, 2500 mm/min, 150 mm/s2.
"""

import math
from dataclasses import dataclass

STEPS_PER_MM = 199.1
SPEED_MM_PER_S = 2500 / 60
ACCELERATION_MM_PER_S2 = 150.0

Point = tuple[float, float, float]
Steps = tuple[int, int, int]


def to_steps(point: Point) -> Steps:
    """The whole steps nearest to a place: 0.2 mm is step 40, which is at 0.2009 mm."""
    x, y, z = (round(value * STEPS_PER_MM) for value in point)
    return x, y, z


def to_mm(steps: Steps) -> Point:
    """Where the axes are after this many steps, in mm."""
    x, y, z = (count / STEPS_PER_MM for count in steps)
    return x, y, z


@dataclass(frozen=True, slots=True)
class Move:
    """A straight line from `start` to `end` in mm, from rest to rest.

    `speed` (mm/s) and `acceleration` (mm/s2) are those along the line.
    """

    start: Point
    end: Point
    speed: float
    acceleration: float

    @property
    def length(self) -> float:
        return math.dist(self.start, self.end)

    @property
    def peak_speed(self) -> float:
        """The highest speed reached: a short line ends before full speed."""
        return min(self.speed, math.sqrt(self.length * self.acceleration))

    @property
    def duration_s(self) -> float:
        if not self.length:
            return 0.0
        ramp_s = self.peak_speed / self.acceleration
        return 2 * ramp_s + (self.length - self.peak_speed * ramp_s) / self.peak_speed

    def travelled(self, t: float) -> float:
        """Millimetres along the line, `t` seconds after the start."""
        if t >= self.duration_s:
            return self.length
        ramp_s = self.peak_speed / self.acceleration
        if t <= ramp_s:
            return self.acceleration * t * t / 2
        left = self.duration_s - t
        if left <= ramp_s:
            return self.length - self.acceleration * left * left / 2
        return self.peak_speed * (t - ramp_s / 2)

    def speed_at(self, t: float) -> float:
        """Speed along the line, mm/s."""
        if not 0 < t < self.duration_s:
            return 0.0
        return min(self.peak_speed, self.acceleration * min(t, self.duration_s - t))

    def braked_at(self, t: float) -> float:
        """Where along the line it stops when braking starts at `t`."""
        way = self.speed_at(t) ** 2 / (2 * self.acceleration)
        return min(self.length, self.travelled(t) + way)

    def point(self, travelled: float) -> Point:
        """The place so many millimetres along the line."""
        part = travelled / self.length if self.length else 1.0
        x, y, z = (a + (b - a) * part for a, b in zip(self.start, self.end, strict=True))
        return x, y, z


def plan(start: Point, end: Point, feed_mm_per_min: float | None = None) -> Move:
    """The fastest straight line within every axis's limits, and no faster than `feed`."""
    length = math.dist(start, end)
    # An axis that has only a part of the way needs only that part of the speed.
    steepest = max(abs(b - a) for a, b in zip(start, end, strict=True)) / length if length else 1.0
    speed = SPEED_MM_PER_S / steepest
    if feed_mm_per_min is not None:
        speed = min(speed, feed_mm_per_min / 60)
    return Move(start, end, speed, ACCELERATION_MM_PER_S2 / steepest)
