"""Record buttons from a picture of the screen: cut out, verified at once, saved with their size."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

from .buttons import FILE, VERSION, Buttons, ButtonsFault, Where, read_picture
from .by_name import look_by_name
from .controls import Control, Controls, Found
from .looking import look_in
from .match import Box, Picture, Sighting, Template, common_scale, look_for, overlap, unfit
from .view import View

IDLE = "idle.png"
"""The picture in which `measure` was marked: the program was idle then."""
SIGNS = ("error", "banner", "busy")


@dataclass(frozen=True, slots=True)
class Known:
    """A button that the driver knows: where it appears, and a description."""

    where: Where
    words: str


KNOWN: dict[str, Known] = {
    "measure": Known("main", "the button that fires"),
    "sample_name": Known("main", "the label beside the field for the sample's name"),
    "export": Known("main", "the button that opens the export dialog"),
    "delete": Known("main", "the button that deletes the selected spectrum"),
    "sync": Known("main", "the button that synchronises with the analyser"),
    "disarm": Known("main", "a button that locks the laser, if there is one"),
    "busy": Known("busy", "a sign that only shows while it measures"),
    "folder": Known("dialog", "the label beside the field for the folder"),
    "separate_spectrum": Known("dialog", "the box for a file for each spectrum, not ticked"),
    "separate_spectrum.on": Known("dialog", "the same box, ticked"),
    "new_folder": Known("dialog", "the box for a separate folder, not ticked"),
    "new_folder.on": Known("dialog", "the same box, ticked"),
    "export_finish": Known("dialog", "the button that starts the export"),
    "export_cancel": Known("dialog", "the button that leaves the dialog"),
    "delete_yes": Known("dialog", "the button that confirms a deletion"),
    "sync_yes": Known("dialog", "the button that confirms a synchronisation"),
    "error": Known("error", "a sign that every error message shows"),
    "error_close": Known("error", "the button that closes an error message"),
}


@dataclass(slots=True)
class Marked:
    """What a person marked: where each button is in the picture, and where to click it."""

    boxes: dict[str, Box]
    at: dict[str, tuple[int, int]] = field(default_factory=dict)
    where: dict[str, Where] = field(default_factory=dict)


def place_of(name: str, marked: Marked) -> Where | None:
    """Where a button appears; None for an unknown name."""
    base = name.removesuffix(".on")
    if name in marked.where or base in marked.where:
        return marked.where.get(name) or marked.where[base]
    if base in KNOWN:
        return KNOWN[base].where
    return "error" if base.startswith("error_") else "busy" if base.startswith("busy_") else None


def cut(picture: Picture, marked: Marked) -> dict[str, Template]:
    """The marked parts of a picture; raises ButtonsFault for one that cannot be used as a template."""
    height, width = picture.shape[:2]
    found = {}
    for name, (x, y, w, h) in marked.boxes.items():
        if w <= 0 or h <= 0 or x < 0 or y < 0 or x + w > width or y + h > height:
            raise ButtonsFault(
                f"{name}: {x},{y},{w},{h} is not inside the picture of {width} x {height}"
            )
        part = picture[y : y + h, x : x + w]
        wrong = unfit(part)
        if wrong is not None:
            raise ButtonsFault(f"{name}: {wrong}")
        found[name] = Template(name, part)
    return found


def found_again(
    picture: Picture, marked: Marked, templates: Mapping[str, Template]
) -> dict[str, str]:
    """Name -> what is wrong, for all that are not found again exactly once where they were marked."""
    wrong = {}
    for name, sight in look_for(picture, list(templates.values()), 1.0).items():
        hit = sight.sure
        if hit is None:
            wrong[name] = sight.words()
        elif overlap(hit.box, marked.boxes[name]) < 0.5:
            wrong[name] = f"{sight.words()}, but it was marked at {marked.boxes[name][:2]}"
    return wrong


def seen_while_idle(
    folder: Path, templates: Mapping[str, Template], marked: Marked
) -> dict[str, str]:
    """Name -> what is wrong, for signs that the idle program shows as well: they would always be there."""
    signs = [
        t for name, t in templates.items()
        if place_of(name, marked) in SIGNS and name != "error_close"
    ]  # fmt: skip
    if not signs or not (folder / IDLE).exists():
        return {}
    sights = look_for(read_picture(folder / IDLE, "the idle program"), signs, 1.0)
    return {
        name: f"{sight.words()} while the program was idle, too: mark more of it, or another part"
        for name, sight in sights.items()
        if sight.hits
    }


def save(
    folder: Path, templates: Mapping[str, Template], marked: Marked, title: str, screen: Picture
) -> None:
    """Write the PNGs and buttons.yaml; what was recorded there before and not now stays."""
    from PIL import Image
    from ruamel.yaml import YAML

    yaml = YAML()
    path = folder / FILE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        said: dict[str, Any] = yaml.load(path.read_text(encoding="utf-8")) if path.exists() else {}
        said = said or {}
        said["labrun_buttons"] = VERSION
        if title:
            said["title"] = title
        said["recorded"] = {"screen": [screen.shape[1], screen.shape[0]]}
        buttons = said.setdefault("buttons", {})
        for name, template in templates.items():
            file = f"{name}.png"
            Image.fromarray(template.picture).save(folder / file)
            _note(buttons, name, file, marked)
        if "measure" in templates and not any(place_of(n, marked) in SIGNS for n in templates):
            Image.fromarray(screen).save(folder / IDLE)
        with path.open("w", encoding="utf-8") as out:
            yaml.dump(said, out)
    except OSError as fault:
        raise ButtonsFault(f"{folder} cannot be written: {fault.strerror or fault}") from fault


def named_controls(view: View, controls: Controls) -> dict[str, dict[str, Any]]:
    """Name -> an entry of buttons.yaml, for each control that can be told from all others of its window."""
    entries: dict[str, dict[str, Any]] = {}
    for window in [*view.dialogs, *([view.main] if view.main is not None else [])]:
        there = controls.all(window)
        for one in there:
            said = [("name", one.name), ("id", one.id), ("type", one.type)]
            # By its name alone, with the type; a name is what a person can check, an id what lasts.
            for words in (("name", "type"), ("id", "type"), ("name", "id", "type")):
                parts = {word: what for word, what in said if word in words and what}
                if ("name" in parts or "id" in parts) and _alone(parts, there):
                    break
            else:
                continue
            if "*" in parts.get("name", ""):
                continue
            where = {} if window == view.main else {"where": "dialog"}
            called = _called(one.name or one.id)
            while called in entries:
                called += "_"
            entries[called] = {"control": parts} | where
    return entries


def save_names(folder: Path, title: str, entries: Mapping[str, dict[str, Any]]) -> list[str]:
    """Write entries that are new there into buttons.yaml; their names."""
    from ruamel.yaml import YAML

    yaml, path = YAML(), folder / FILE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        said = (yaml.load(path.read_text(encoding="utf-8")) if path.exists() else None) or {}
        said |= {"labrun_buttons": VERSION, "title": title}
        buttons = said.setdefault("buttons", {})
        new = [name for name in entries if name not in buttons]
        buttons |= {name: entries[name] for name in new}
        with path.open("w", encoding="utf-8") as out:
            yaml.dump(said, out)
    except OSError as fault:
        raise ButtonsFault(f"{folder} cannot be written: {fault.strerror or fault}") from fault
    return new


def _alone(parts: Mapping[str, str], there: Sequence[Found]) -> bool:
    wanted = Control(**parts)
    fit = [
        one for one in there if wanted.fits(one.name, one.id) and wanted.type in (None, one.type)
    ]
    return len(fit) == 1


def _called(words: str) -> str:
    """A name for YAML: `Save as...` is save_as."""
    return re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")[:40] or "control"


def _note(buttons: dict[str, Any], name: str, file: str, marked: Marked) -> None:
    base, dot, _ = name.partition(".on")
    if dot:
        if base not in buttons:
            raise ButtonsFault(f"{name}: record {base}, the box that is not ticked, first")
        buttons[base]["on"] = file
        return
    entry = buttons.setdefault(name, {})
    entry["file"] = file
    where = place_of(name, marked)
    if where not in (None, "main"):
        entry["where"] = where
    if name in marked.at:
        entry["at"] = list(marked.at[name])


def looked(buttons: Buttons, view: View, controls: Controls | None = None) -> dict[str, Sighting]:
    """Name -> what is seen of it, for all recorded buttons, each compared with all the others."""
    wanted = buttons.controls(buttons.named(*get_args(Where)))
    by_name = look_by_name(view, buttons, wanted, controls) if controls is not None else {}
    main = [buttons.template(name) for name in buttons.named("main") if name not in wanted]
    others = buttons.all_but(main)
    sights = look_for(view.picture, main, rivals=others)
    scale = common_scale(sights.values())
    return sights | look_in(view, buttons, [other.name for other in others], scale) | by_name


def drawn(view: View, sights: Mapping[str, Sighting]) -> Picture:
    """The picture with a box and a score round everything that was found; grey what only resembles."""
    import cv2

    picture = view.picture.copy()
    for name, sight in sights.items():
        for hit in sight.hits or ([sight.nearest] if sight.nearest is not None else []):
            x, y, w, h = hit.box
            colour = (
                (20, 160, 40)
                if sight.sure is not None
                else (200, 30, 30)
                if sight.hits
                else (150,) * 3
            )
            cv2.rectangle(picture, (x, y), (x + w, y + h), colour, 2)
            label = f"{name} {hit.score:.2f}"
            at = (x, y - 4 if y > 14 else y + h + 12)
            cv2.putText(
                picture, label, at, cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255, 255, 255), 3, cv2.LINE_AA
            )
            cv2.putText(picture, label, at, cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)
    return picture
