"""The paper's `custom_interfaces`, field by field as its programs use them."""

from ....schemas.lab import Lab
from ..interfaces.kinds import ActionKind, Field, Message, ServiceKind
from ..interfaces.own_kinds import text

PAPER_PACKAGE = "custom_interfaces"
P = PAPER_PACKAGE


def _action(name: str, goal: tuple[Field, ...], result: tuple[Field, ...], told: str) -> ActionKind:
    return ActionKind(
        P, name, Message(P, f"{name}Goal", goal), Message(P, f"{name}Result", result),
        Message(P, f"{name}Feedback", (text(told),)),
    )  # fmt: skip


MOVE_GANTRY = _action(
    "MoveGantry",
    (text("cmd", "Lines of G-code: G0, G1, G20, G21, G90, G91, $H"),),
    (text("msg"),),
    "msg",
)
TAKE_MEASUREMENT = _action("TakeMeasurement", (), (text("msg"),), "feedback")
EXPORT_SPECTRUM = _action("ExportSpectrum", (), (text("msg"),), "feedback")
ANALYZE_SPECTRUM = _action("AnalyzeSpectrum", (), (
    Field("peak_range", "string", "peak_range", array="[]"),
    Field("peak_area", "float64", "peak_area", array="[]"),
    text("msg"),
), "feedback")  # fmt: skip
GANTRY_STATUS = Message(P, "GantryStatus", (
    text("work", "Idle, Run, Home, Alarm, Hold or Offline"),
    Field("x", "float64", "x", comment="in mm, from the zero that /set_zero has set"),
    Field("y", "float64", "y"), Field("z", "float64", "z"),
))  # fmt: skip
SET_ZERO = ServiceKind(
    P, "SetZero", Message(P, "SetZeroRequest", (text("axis", "x, y, z, or several of them"),)),
    Message(P, "SetZeroResponse", (Field("success", "bool", "success"), text("message"))),
)  # fmt: skip
LAUNCH_REQUEST = ServiceKind(
    P, "LaunchRequest",
    Message(P, "LaunchRequestRequest", (text("cmd"), text("package"), text("file_name"), text("args"))),
    Message(P, "LaunchRequestResponse", (
        text("file_name"), text("message"), Field("is_launched", "bool", "is_launched"),
    )),
)  # fmt: skip


KINDS: dict[str, Message | ActionKind | ServiceKind] = {
    "/move_gantry": MOVE_GANTRY, "/take_measurement": TAKE_MEASUREMENT,
    "/export_spectrum": EXPORT_SPECTRUM, "/analyze_spectrum": ANALYZE_SPECTRUM,
    "/gantry_status": GANTRY_STATUS, "/set_zero": SET_ZERO, "/launch": LAUNCH_REQUEST,
}  # fmt: skip
"""The paper's name -> its type."""


def paper_kinds(lab: Lab) -> list[Message | ActionKind | ServiceKind]:
    """Those that a lab's `ros` uses."""
    if lab.ros is None:
        return []
    names = {*lab.ros.aliases} | ({"/launch"} if lab.ros.launch else set())
    return [kind for name, kind in KINDS.items() if name in names]
