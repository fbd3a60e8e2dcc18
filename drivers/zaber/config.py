"""What a lab says of its stages: which device moves which axis, and how long a microstep is.

stages:
  x: {device: 1, microstep_um: 0.49609375}
  y: {device: 2, axis: 1, microstep_um: 0.49609375}      # axis 1 of a controller that has several
  a: {device: 3, microstep_deg: 0.000234375}             # turned by a rotary stage
An axis of x, y, z that no stage moves stays at 0.
"""

from typing import Any

from pydantic import Field, ValidationError

from ...schemas.model import Model
from ..driver import check_keys, misfit
from ..motion.gantry import AXES


class StageConfig(Model):
    """One stage; without the length of its microstep the maker's database is asked for it."""

    device: int = Field(ge=1, le=99)
    axis: int = Field(default=1, ge=1, le=9)
    microstep_um: float | None = Field(default=None, gt=0, strict=False)
    microstep_deg: float | None = Field(default=None, gt=0, strict=False)

    def microstep(self) -> float | None:
        """In mm, or in degrees; None where the lab does not say it."""
        return self.microstep_deg if self.microstep_um is None else self.microstep_um / 1000


def read_stages(written: Any) -> dict[int, StageConfig]:
    """Machine axis (0 is x) -> its stage; raises ValueError with the first error."""
    if not isinstance(written, dict) or not written:
        raise ValueError(
            f"stages is {written!r}; it names the stage of each axis: {{x: {{device: 1}}, y: {{device: 2}}}}"
        )
    check_keys(AXES, written, "stages")
    stages: dict[int, StageConfig] = {}
    for name in sorted(written, key=AXES.index):
        try:
            stages[AXES.index(name)] = one = StageConfig.model_validate(written[name])
        except ValidationError as fault:
            raise misfit(fault, "stages", name) from fault
        wrong = one.microstep_deg if name in "xyz" else one.microstep_um
        if wrong is not None:
            right = "microstep_um" if name in "xyz" else "microstep_deg"
            raise ValueError(f"stages.{name}: the microstep of this axis is said as {right}")
    missing = [name for name in AXES[3 : max(stages) + 1] if AXES.index(name) not in stages]
    if missing:
        raise ValueError(f"stages has no {missing[0]}, but a later axis")
    places = [(one.device, one.axis) for one in stages.values()]
    for place in places:
        if places.count(place) > 1:
            raise ValueError(f"stages: device {place[0]}, axis {place[1]} is named twice")
    return stages
