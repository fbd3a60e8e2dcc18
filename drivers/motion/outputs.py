"""What a gantry's controller switches beside its axes: a laser, a gas valve."""

from dataclasses import dataclass
from typing import Any

from ..driver import Misfit

KINDS = {"spindle": ("M3", "M5"), "mist": ("M7", "M9"), "flood": ("M8", "M9")}


@dataclass(frozen=True, slots=True)
class Output:
    """The lines that switch it; `has_power`: the first one takes a power as S."""

    on: str
    off: str
    has_power: bool = False

    def line(self, on: bool, power: float, full: float) -> str:
        """The line for a power in percent; `full` is what S is at 100 ($30)."""
        if not on:
            return self.off
        return f"{self.on}S{power / 100 * full:.3f}" if self.has_power else self.on


def read_outputs(config: dict[str, Any]) -> dict[str, Output]:
    """Outputs of `outputs: {laser: spindle, argon: mist, lamp: {on: M62 P0, off: M63 P0}}`."""
    written = config.get("outputs") or {}
    if not isinstance(written, dict):
        message = f"outputs is {written!r}; write it as {{laser: spindle, argon: mist}}"
        raise Misfit(message, ("outputs",))
    return {str(name): _output(str(name), one) for name, one in written.items()}


def _output(name: str, written: Any) -> Output:
    if isinstance(written, str) and written in KINDS:
        return Output(*KINDS[written], has_power=written == "spindle")
    if isinstance(written, dict) and set(written) == {"on", "off"}:
        return Output(str(written["on"]), str(written["off"]))
    raise Misfit(
        f"output {name} is {written!r}; it is one of {', '.join(KINDS)}, or the lines that switch it: "
        f"{{on: M62 P0, off: M63 P0}}",
        ("outputs", name),
    )
