"""Where a device stands on one axis, by its own latest word."""

import time

from ...schemas.quantity import magnitude_in
from ..guard.refusal import Refusal
from ..models.devices import Axis
from .station import Station

FRESH_S = 3.0
RESULT_S = 1.0
"""So long what the last action gave is newer than the status, which comes each second."""


def where_mm(station: Station, axis: Axis) -> float:
    """Millimetres; raises Refusal where nobody has said for too long, or nobody knows."""
    now = time.time()
    if now - station.result_at < RESULT_S and axis in station.result:
        value = station.result[axis]
    else:
        if now - station.status_at > FRESH_S:
            raise Refusal(409, "OLD_STATUS", f"{station.name} has not said for a while where it is")
        value = station.status.get(axis)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Refusal(409, "NO_POSITION", f"{station.name} does not know where its {axis} stands")
    unit = station.contract.status.get("properties", {}).get(axis, {}).get("unit", "mm")
    return magnitude_in(f"{value!r} {unit}", "mm")
