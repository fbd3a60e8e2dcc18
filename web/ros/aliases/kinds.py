"""The paper's `custom_interfaces`, field for field.

Living-Minerals-Lab/mini_platform, `src/custom_interfaces`, at 5cbf1ce, and what AECP_ROS2 at 349c5d0 adds
to it for the camera. What labrun has to say beyond these fields is in the feedback, in the log, and in
the results of its own actions.
"""

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


def _service(name: str, request: tuple[Field, ...], response: tuple[Field, ...]) -> ServiceKind:
    return ServiceKind(
        P, name, Message(P, f"{name}Request", request), Message(P, f"{name}Response", response)
    )


def _float(name: str, comment: str = "") -> Field:
    return Field(name, "float32", name, comment=comment)


MOVE_GANTRY = _action(
    "MoveGantry",
    (text("cmd", "Lines of G-code: G0, G1, G20, G21, G90, G91, $H"),),
    (text("msg"),),
    "msg",
)
TAKE_MEASUREMENT = _action("TakeMeasurement", (), (), "feedback")
EXPORT_SPECTRUM = _action("ExportSpectrum", (), (), "feedback")
ANALYZE_SPECTRUM = _action("AnalyzeSpectrum", (), (
    Field("peak_range", "string", "peak_range", array="[]"),
    Field("peak_area", "float32", "peak_area", array="[]"),
), "feedback")  # fmt: skip
GANTRY_STATUS = Message(P, "GantryStatus", (
    text("work", "Idle, Run, Running, Alarm, Hold, Pending or Offline"),
    _float("x", "in mm, from the zero that /set_zero has set"), _float("y"), _float("z"),
))  # fmt: skip
SET_ZERO = _service("SetZero", (text("axis", "x, y, z, or several of them"),), ())
IS_RDY = _service("IsRdy", (), (Field("ready", "bool", "ready"),))
MOVE_GANTRY_CALL = _service("MoveGantry", (text("cmd"),), (text("response"),))
LAUNCH_REQUEST = _service(
    "LaunchRequest",
    (text("cmd"), text("package"), text("file_name"), text("args")),
    (text("message"), Field("is_launched", "bool", "is_launched"), text("file_name")),
)
BOUNDING_BOX = Message(P, "BoundingBox", (_float("x"), _float("y"), _float("w"), _float("h")))
GANTRY_LOCATION = Message(P, "GantryLocation", (_float("x_g"), _float("y_g"), _float("z_g")))
SAMPLES = (
    Field("boxes", "BoundingBox", "boxes", array="[]", message=BOUNDING_BOX),
    Field("ids", "int32", "ids", array="[]"),
    Field("gantry_locs", "GantryLocation", "gantry_locs", array="[]", message=GANTRY_LOCATION),
)
DETECT_SAMPLES = _action("DetectSamples", (), SAMPLES, "feedback")
SAMPLE_DETECTION = Message(P, "SampleDetectionRes", SAMPLES)


PAPER_KINDS: tuple[Message | ActionKind | ServiceKind, ...] = (
    MOVE_GANTRY, TAKE_MEASUREMENT, EXPORT_SPECTRUM, ANALYZE_SPECTRUM, GANTRY_STATUS, SET_ZERO,
    IS_RDY, MOVE_GANTRY_CALL, LAUNCH_REQUEST, DETECT_SAMPLES, BOUNDING_BOX, GANTRY_LOCATION,
    SAMPLE_DETECTION,
)  # fmt: skip
"""All of the paper's package: its fields, their types and their order are the wire format."""


NAMES = (
    "/move_gantry", "/take_measurement", "/export_spectrum", "/analyze_spectrum", "/gantry_status",
    "/set_zero", "/is_gantry_rdy", "/is_analytical_dev_rdy", "/detect_samples",
)  # fmt: skip


def paper_kinds(lab: Lab) -> list[Message | ActionKind | ServiceKind]:
    """The whole package if a lab uses any of it: sourced, it may hide the original."""
    if lab.ros is None or not (lab.ros.launch or {*lab.ros.aliases} & {*NAMES}):
        return []
    return list(PAPER_KINDS)
