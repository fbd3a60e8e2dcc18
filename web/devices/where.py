"""Position of a device on one axis, by its latest report."""

from ...schemas.quantity import is_number, magnitude_in
from ..local.refusal import Refusal
from ..models.devices import Axis
from .device_link import DeviceLink

FRESH_S = 3.0
RESULT_S = 1.0
"""For this long the last action's result is newer than the status, which comes each second."""


def where_mm(device_link: DeviceLink, axis: Axis) -> float:
    """Millimetres; raises Refusal if the report is too old or the position unknown."""
    if device_link.result_age_s < RESULT_S and axis in device_link.result:
        value = device_link.result[axis]
    else:
        if device_link.status_age_s > FRESH_S:
            raise Refusal(
                409, "OLD_STATUS", f"{device_link.name} has not reported its position for a while"
            )
        value = device_link.status.get(axis)
    if not is_number(value):
        raise Refusal(409, "NO_POSITION", f"{device_link.name} does not know its {axis} position")
    unit = device_link.contract.status.get("properties", {}).get(axis, {}).get("unit", "mm")
    return magnitude_in(f"{value!r} {unit}", "mm")
