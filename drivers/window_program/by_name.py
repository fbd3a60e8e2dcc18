"""Look for buttons by the names that the program gives its controls: each sight as one of a picture."""

from collections.abc import Mapping, Sequence

from .buttons import Buttons
from .controls import Control, Controls, Found
from .looking import OF_DIALOGS
from .match import Hit, Sighting
from .view import View
from .windows import Window


def found_in(view: View, control: Control, where: str, controls: Controls) -> list[Found]:
    """The controls that fit: of a dialog in the dialogs, if one is open; else in the main window."""
    return [one for window in _windows(view, where) for one in controls.find(window, control)]


def look_by_name(
    view: View, buttons: Buttons, wanted: Mapping[str, Control], controls: Controls
) -> dict[str, Sighting]:
    """Name -> what is seen of it, in the picture's coordinates; one that is disabled is greyed out."""
    sights = {}
    for name, control in wanted.items():
        found = found_in(view, control, buttons.button(name).where, controls)
        hits = tuple(_hit(name, one, view) for one in found)
        hint = f"its windows show no {control.words()}; `labrun record-program --names` lists what they have"
        sights[name] = Sighting(name, hits, hint=hint)
    return sights


def _windows(view: View, where: str) -> Sequence[Window]:
    if where in OF_DIALOGS and view.dialogs:
        return view.dialogs
    return [view.main] if view.main is not None else []


def _hit(name: str, found: Found, view: View) -> Hit:
    x, y, width, height = (round(n * view.ratio) for n in found.box)
    box = x - view.corner[0], y - view.corner[1], width, height
    return Hit(name, 1.0, 1.0, box, 1.0 if found.enabled else 0.0, 0.0)
