"""The recorded buttons of one analyser program: a folder of PNGs and buttons.yaml.

labrun_buttons: 1
title: Profile Builder            # part of the window's title; left out: the whole screen
buttons:
  measure: {file: measure.png}
  sample_name: {file: sample_name.png, at: [140, 0]}    # click this far from its middle
  new_folder: {file: new_folder.png, on: new_folder.on.png, where: dialog}
  error_interlock: {file: interlock.png, where: error, says: Interlock open, happened: no}
  delete: {control: {name: Delete, type: Button}}       # by name, on Windows: no picture
export: [{click: sample_name}, {type: "{name}"}, ...]   # left out: the paper's own order
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator

from ...schemas.contract import Happened
from ...schemas.model import Model, first_fault
from .controls import Control
from .match import THRESHOLD, Picture, Template, unfit

FILE = "buttons.yaml"
VERSION = 1

Where = Literal["main", "dialog", "error", "banner", "busy"]
"""main: always in the main window; dialog: while exporting; error: the sign of a modal error in a
window of its own, or the button that closes it; banner: the sign of an error that is drawn in the main
window; busy: a sign that is there while the analyser works."""

STEP_WORDS = ("click", "type", "press", "tick", "untick", "wait", "gone")
PAPER_EXPORT: tuple[dict[str, str], ...] = (
    {"click": "sample_name"},
    {"type": "{name}"},
    {"click": "export"},
    {"wait": "folder"},
    {"type": "{folder}"},
    {"press": "enter"},
    {"tick": "separate_spectrum"},
    {"tick": "new_folder"},
    {"click": "export_finish"},
)
"""The order of the paper's analyser; a step whose button was not recorded is left out."""
NEEDED = ("measure", "export")


class ButtonsFault(ValueError):
    """A folder of buttons that cannot be used; the text says which file and why."""


class Button(Model):
    """One recorded place: a picture, or a control; `at` is where to click, in pixels from its middle."""

    file: str | None = None
    control: Control | None = None
    on: str | None = None
    at: tuple[int, int] = Field(default=(0, 0), strict=False)
    where: Where = "main"
    threshold: float = Field(default=THRESHOLD, ge=0.5, le=1.0)
    says: str = ""
    happened: Happened = "unknown"

    @model_validator(mode="after")
    def _seen_somehow(self) -> "Button":
        if (self.file is None) == (self.control is None):
            raise ValueError("a button has a picture, `file`, or a `control`, by its name")
        return self

    @property
    def tickable(self) -> bool:
        """Whether it can be told if it is ticked."""
        return self.on is not None or self.control is not None


class Step(Model):
    """One step of an export: exactly one of the keywords."""

    click: str | None = None
    type: str | None = None
    press: str | None = None
    tick: str | None = None
    untick: str | None = None
    wait: str | None = None
    gone: str | None = None

    @model_validator(mode="after")
    def _one_word(self) -> "Step":
        if len(self.words()) != 1:
            raise ValueError(f"one step has one of {', '.join(STEP_WORDS)}")
        return self

    def words(self) -> list[tuple[str, str]]:
        """The step as (word, what)."""
        return [(w, what) for w in STEP_WORDS if (what := getattr(self, w)) is not None]


class ButtonsFile(Model):
    """The content of buttons.yaml."""

    labrun_buttons: Literal[1]
    title: str = ""
    buttons: dict[str, Button] = Field(min_length=1)
    export: list[Step] | None = None
    recorded: dict[str, Any] = Field(default_factory=dict)


class Buttons:
    """A folder of buttons, read and checked."""

    def __init__(self, folder: Path, said: ButtonsFile, templates: dict[str, Template]) -> None:
        self.folder = folder
        self.title = said.title
        self.recorded = said.recorded
        self._said = said
        self._templates = templates

    def __contains__(self, name: str) -> bool:
        return name in self._said.buttons

    def button(self, name: str) -> Button:
        return self._said.buttons[name]

    def template(self, name: str) -> Template:
        """What it looks like; `NAME.on` is a check box that is ticked."""
        return self._templates[name]

    @property
    def by_name(self) -> bool:
        """Whether any of them is known by a control's name."""
        return bool(self.controls(self._said.buttons))

    def controls(self, names: Iterable[str]) -> dict[str, Control]:
        """Those of these buttons that are known by a control's name."""
        there = {name: self._said.buttons[name] for name in names if name in self._said.buttons}
        return {n: button.control for n, button in there.items() if button.control is not None}

    def all_but(self, templates: list[Template]) -> list[Template]:
        """Everything else that was recorded."""
        names = {template.name for template in templates}
        return [template for name, template in self._templates.items() if name not in names]

    def named(self, *places: Where) -> list[str]:
        """Names of the buttons that belong to these places."""
        return [name for name, button in self._said.buttons.items() if button.where in places]

    def steps(self) -> list[tuple[str, str]]:
        """The steps of an export; steps of the paper's order without a recorded button are left out."""
        if self._said.export is not None:
            return [pair for step in self._said.export for pair in step.words()]
        pairs = [pair for step in PAPER_EXPORT for pair in step.items()]
        kept = []
        for n, (word, what) in enumerate(pairs):
            if word in ("click", "tick", "untick", "wait") and what not in self:
                continue
            typed_into = pairs[n - 1][1] if n else ""
            if word == "type" and what == "{name}" and typed_into not in self:
                continue
            kept.append((word, what))
        return kept


def read_buttons(folder: Path, needed: tuple[str, ...] = NEEDED) -> Buttons:
    """The buttons in a folder; raises ButtonsFault with the reason."""
    said = _read_file(folder / FILE)
    missing = [name for name in needed if name not in said.buttons]
    if missing:
        raise ButtonsFault(
            f"{folder / FILE} has no {' and no '.join(missing)}; record it with "
            f"`labrun record-program --buttons -o {folder}`"
        )
    templates: dict[str, Template] = {}
    for name, button in said.buttons.items():
        if button.file is None:
            continue
        templates[name] = Template(name, read_picture(folder / button.file, name), button.threshold)
        if button.on is not None:
            on = read_picture(folder / button.on, f"{name}, ticked")
            templates[f"{name}.on"] = Template(f"{name}.on", on, button.threshold)
    buttons = Buttons(folder, said, templates)
    if not said.title and buttons.by_name:
        raise ButtonsFault(
            f"{folder / FILE}: write `title`: controls are looked for in the windows of one program"
        )
    _check_steps(folder, buttons)
    return buttons


def _check_steps(folder: Path, buttons: Buttons) -> None:
    for word, what in buttons.steps():
        if word in ("click", "tick", "untick", "wait", "gone") and what not in buttons:
            raise ButtonsFault(f"{folder / FILE}: export: {word}: {what} is not a recorded button")
        if word in ("tick", "untick") and not buttons.button(what).tickable:
            raise ButtonsFault(
                f"{folder / FILE}: {what} should be ticked, but only its empty state was recorded; "
                f"record {what}.on as well"
            )


def _read_file(path: Path) -> ButtonsFile:
    from ruamel.yaml import YAML, YAMLError

    try:
        return ButtonsFile.model_validate(YAML(typ="safe").load(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise ButtonsFault(
            f"there is no {path}; record the program's buttons with `labrun record-program --buttons -o "
            f"{path.parent}`"
        ) from None
    except ValidationError as fault:
        raise ButtonsFault(f"{path}: {first_fault(fault)}") from fault
    except (OSError, UnicodeDecodeError, YAMLError) as fault:
        raise ButtonsFault(f"{path} cannot be read: {' '.join(str(fault).split())}") from fault


def read_picture(path: Path, name: str) -> Picture:
    """A recorded picture; raises ButtonsFault if it cannot be read or used as a template."""
    import numpy as np
    from PIL import Image

    try:
        with Image.open(path) as image:
            picture = np.asarray(image.convert("RGB"))
    except (OSError, ValueError) as fault:
        raise ButtonsFault(f"the picture of {name}, {path}, cannot be read: {fault}") from fault
    wrong = unfit(picture)
    if wrong is not None:
        raise ButtonsFault(f"the picture of {name}, {path}, cannot be used as a template: {wrong}")
    return picture
