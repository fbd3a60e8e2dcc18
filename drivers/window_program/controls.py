"""What a program says of its own controls: names, states and texts, instead of pictures of them.

On Windows by UI Automation. On X11 there is nothing of the kind that all programs offer: pictures remain.
"""

import re
from dataclasses import dataclass
from typing import Protocol

from pydantic import model_validator

from ...schemas.model import Model
from .match import Box
from .windows import Window


class Control(Model):
    """Which control: its name, in which `*` stands for anything, its id that no user sees, its type.

    `Inspect.exe` of Windows' SDK shows all three; types are UI Automation's: Button, Edit, CheckBox, ...
    """

    name: str | None = None
    id: str | None = None
    type: str | None = None

    @model_validator(mode="after")
    def _known_by_something(self) -> "Control":
        if not self.name and not self.id:
            raise ValueError("a control has a `name`, or an `id`")
        return self

    def fits(self, name: str, known_id: str) -> bool:
        """Whether a control of the right type is this one."""
        pattern = re.escape(self.name or "*").replace(r"\*", ".*")
        named = re.fullmatch(pattern, name, re.DOTALL) is not None
        return named and self.id in (None, known_id)

    def words(self) -> str:
        """For a person."""
        said = [self.type or "control", *([repr(self.name)] if self.name else [])]
        return " ".join([*said, *([f"with the id {self.id}"] if self.id else [])])


@dataclass(frozen=True, slots=True)
class Found:
    """One control that is visible now; `box` on the screen, `ticked` None where it cannot be."""

    name: str
    id: str
    type: str
    box: Box
    enabled: bool
    ticked: bool | None
    text: str


class Controls(Protocol):
    """What a desktop tells of the controls of a window."""

    def find(self, window: Window, wanted: Control) -> list[Found]:
        """The visible controls that fit."""
        ...

    def all(self, window: Window) -> list[Found]:
        """Everything visible in it that has a name or an id."""
        ...
