"""A picture of the bench that a person took into a run: a line of its `snapshots/snapshots.jsonl`."""

from typing import Annotated

from pydantic import Field

from .model import Model


class Snapshot(Model):
    """It changes nothing of what was measured; `file` is relative to the run's folder, `at` is UTC."""

    file: Annotated[str, Field(max_length=300)]
    device: Annotated[str, Field(max_length=200)]
    by: Annotated[str, Field(max_length=200)] = ""
    at: Annotated[str, Field(max_length=40)]
    sha256: Annotated[str, Field(max_length=64)]
