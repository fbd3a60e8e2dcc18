"""Trouble on the screen as errors of the contract, with a picture of it for a person."""

import time
from pathlib import Path

from ...system.files import remove
from .program import NoScreen, NotClicked, Trouble
from .view import View

KEPT = 20
ERRORS = {
    "unseen": "ButtonNotFound",
    "twice": "ButtonNotFound",
    "dialog": "DialogOpen",
    "error": "DialogOpen",
}


def failure_of(fault: Trouble | NoScreen | NotClicked) -> tuple[str, str]:
    """(error name, words)."""
    if isinstance(fault, Trouble):
        return ERRORS.get(fault.state, "Rejected"), str(fault)
    return "Rejected", str(fault)


def put_picture(view: View | None, folder: Path) -> str:
    """Save a picture, keeping the latest 20; returns a note that says where, empty if that fails."""
    if view is None:
        return ""
    from PIL import Image

    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{time.strftime('%Y-%m-%d_%H-%M-%S')}_{time.time_ns() % 10**6:06}.png"
        Image.fromarray(view.picture).save(path)
        for old in sorted(folder.glob("*.png"))[:-KEPT]:
            remove(old)
    except OSError:
        return ""
    return f" (its picture: {path})"
