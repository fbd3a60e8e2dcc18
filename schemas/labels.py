"""What people say of a run beside its protocol: `labels.json` in its folder."""

from typing import Annotated

from pydantic import Field, StringConstraints

from .model import Model

Tag = Annotated[str, StringConstraints(min_length=1, max_length=60, pattern=r"^[^\s,:]+$")]


class Labels(Model):
    """They can be changed at any time, and change nothing of what was measured."""

    sample: Annotated[str, Field(max_length=80)] = ""
    """What it was measured on, where no parameter `sample` says so."""
    tags: Annotated[list[Tag], Field(max_length=30, default_factory=list)]
    note: Annotated[str, Field(max_length=2000)] = ""
