"""The base of everything that the page asks and is told, and what a refusal looks like."""

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field


class Told(BaseModel):
    """Unknown keys are faults; names are the same in Python, JSON and TypeScript."""

    model_config = ConfigDict(extra="forbid")


class FoundProblem(Told):
    """A problem as the one checker gives it; line and column start at 1."""

    file: str
    line: int
    column: int
    length: int
    severity: Literal["error", "warning"]
    code: str
    message: str
    hint: str = ""
    pointer: str | None = Field(
        default=None,
        description="JSON Pointer (RFC 6901) of the value or key in the protocol; null where the "
        "problem is in another file or the text is no YAML.",
    )


class Fault(Told):
    """Every refusal: what, in words, and what now. The HTTP status says which kind it is."""

    code: str = Field(description="A word for programs, such as `LATE`, `NO_CONTROL`, `HELD`.")
    message: str = Field(description="A sentence for people.")
    hint: str = ""
    problems: list[FoundProblem] = Field(default_factory=list)
    details: dict[str, Any] = Field(default_factory=dict)


class Said(Told):
    """What was answered to something that was asked for, in words."""

    text: str
