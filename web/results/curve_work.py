"""The calibration curve of an element, drawn in the worker."""

from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

from ..local.refusal import not_found

REDUCTION = "labrun.reduction"
KEPT = "used/*.calibration"  # what a run keeps of the calibrations that it was given


def curve(asked: dict[str, Any]) -> dict[str, Any]:
    """As SVG, of the first calibration that the run in `folder` used and that has the element."""
    room = import_module(f"{REDUCTION}.calibration.calibration")
    element = asked["element"]
    for path in sorted(Path(asked["folder"]).glob(KEPT)):
        try:
            known = room.read_calibration(path.read_text(encoding="utf-8"))
        except room.CalibrationFault:
            continue
        if element in known.elements:
            only = room.Calibration(known.card, {element: known.elements[element]})
            return {"svg": _drawn(only)}
    raise not_found(
        "calibration curve", element, "a run has those of the calibration that it was given"
    )


def _drawn(calibration: Any) -> str:
    figures = f"{REDUCTION}.figures"
    figure = import_module(f"{figures}.calibration_curves").calibration_figure
    svg = StringIO()
    with import_module(f"{figures}.paper").paper():
        figure(calibration).savefig(
            svg, format="svg", facecolor="white", metadata={"Date": None, "Creator": None}
        )
    return svg.getvalue()
