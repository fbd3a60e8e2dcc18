"""Where a titration ends: the function of `titration.yaml`, for you to change."""

from itertools import pairwise
from typing import Annotated


def end_point(volumes: list[Annotated[float, "mL"]], ph: list[float]) -> Annotated[float, "mL"]:
    """The volume at which the curve is steepest: where its second derivative goes through zero."""
    middles = [(a + b) / 2 for a, b in pairwise(volumes)]
    rises = [b - a for a, b in pairwise(ph)]
    slopes = [rise / (b - a) for rise, (a, b) in zip(rises, pairwise(volumes), strict=True)]
    top = slopes.index(max(slopes))
    if not 0 < top < len(slopes) - 1:
        raise ValueError(f"the steepest place is at the end of the curve, {middles[top]:.2f} mL")
    # The top of a parabola through the three steepest slopes.
    (x0, x1, x2), (y0, y1, y2) = middles[top - 1 : top + 2], slopes[top - 1 : top + 2]
    rise, fall = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    return (x0 + x1) / 2 + (x2 - x0) / 2 * rise / (rise - fall)
