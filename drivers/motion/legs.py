"""The straight lines of a way: one, or three where a safe height is given: up, across, down."""

NEAR_MM = 0.006

Places = dict[str, float]


def legs(here: Places, wanted: Places, safe_z: float | None) -> list[Places]:
    """The targets one after the other; positions by axis, in mm. Axes left out stay."""
    across = {axis: value for axis, value in wanted.items() if axis != "z"}
    if safe_z is None or all(abs(here[axis] - value) < NEAR_MM for axis, value in across.items()):
        return [wanted]
    end = wanted.get("z", here["z"])
    top = max(safe_z, end, here["z"])
    up = [{"z": top}] if top > here["z"] + NEAR_MM else []
    return [*up, across, *([{"z": end}] if end < top - NEAR_MM else [])]
