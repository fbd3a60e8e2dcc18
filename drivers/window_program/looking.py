"""Look for buttons where they belong: those of a dialog in the dialog's own window, if one is open.

Short labels ("Folder:") resemble other words of a program to 0.75 and more. In the dialog's window
there are few of those; where no such window is open, a dialog may still be drawn into the main one,
but has to fit better.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from .buttons import Buttons
from .match import ALONE, Sighting, Template, look_for, moved
from .view import View

OF_DIALOGS = ("dialog", "error")
SMALL, EASED = 0.7, 0.08
"""Below the first size check boxes of 8 pixels fit hardly better than by 0.65; within the dialog's own
window nothing else does."""


def look_in(
    view: View, buttons: Buttons, names: Sequence[str], scale: float | None
) -> dict[str, Sighting]:
    """Name -> what is seen of it, in the picture's coordinates; each is compared with all the others."""
    of_dialogs = [n for n in names if buttons.button(n.removesuffix(".on")).where in OF_DIALOGS]
    wanted = {name: buttons.template(name) for name in names}
    rivals = buttons.all_but(list(wanted.values()))
    if not of_dialogs or view.main is None:
        return look_for(view.picture, list(wanted.values()), scale, rivals) if wanted else {}
    inside = [_held_to(wanted.pop(n), view, scale) for n in of_dialogs]
    sights = (
        look_for(view.picture, list(wanted.values()), scale, [*rivals, *inside]) if wanted else {}
    )
    x, y, width, height = view.dialog_box()
    part = view.picture[y : y + height, x : x + width]
    found = look_for(part, inside, scale, [*rivals, *wanted.values()])
    return _in_order(names, sights | {n: moved(sight, x, y) for n, sight in found.items()})


def _held_to(template: Template, view: View, scale: float | None) -> Template:
    """How well a dialog's button has to match."""
    if not view.dialogs:
        return replace(template, threshold=min(0.95, template.threshold + ALONE))
    small = scale is not None and scale < SMALL
    return replace(template, threshold=template.threshold - EASED) if small else template


def _in_order(names: Sequence[str], sights: Mapping[str, Sighting]) -> dict[str, Sighting]:
    return {name: sights[name] for name in names}
