"""The base of all requests and answers of the page, and the form of a refusal."""

from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field


class ApiModel(BaseModel):
    """Unknown keys are errors; names are the same in Python, JSON and TypeScript."""

    model_config = ConfigDict(extra="forbid")

    @classmethod
    def of(cls, other: object, **more: Any) -> Self:
        """Its fields as another object has them under the same names; `more` are those that differ."""
        same = (name for name in cls.model_fields if name not in more and hasattr(other, name))
        return cls(**{name: getattr(other, name) for name in same}, **more)


class FoundProblem(ApiModel):
    """A problem from the checker; line and column start at 1."""

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
        "problem is in another file or the text is not YAML.",
    )


class Fault(ApiModel):
    """Every refusal: what is wrong and what to do. The HTTP status gives its kind."""

    code: str = Field(description="A word for programs, such as `LATE`, `NO_CONTROL`, `HELD`.")
    message: str = Field(description="A sentence for people.")
    hint: str = ""
    problems: list[FoundProblem] = Field(default_factory=list)
    details: dict[str, Any] = Field(default_factory=dict)


class Answer(ApiModel):
    """The answer to a request, as text."""

    text: str
