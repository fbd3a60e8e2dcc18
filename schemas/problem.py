"""A fault in something a person wrote: where it is, what it is, what to do."""

from typing import Literal

from pydantic import Field

from .model import Model

Severity = Literal["error", "warning"]


def severity_of(code: str) -> Severity:
    """By its letter: E101 is an error, W101 a warning."""
    return "error" if code.startswith("E") else "warning"


class Problem(Model):
    """One fault at one place. Lines and columns start at 1, as editors count."""

    file: str
    line: int = Field(ge=1)
    column: int = Field(ge=1)
    severity: Severity = "error"
    code: str
    message: str
    hint: str = ""
    length: int = Field(default=1, exclude=True)

    @property
    def place(self) -> tuple[str, int, int, str]:
        """The key by which problems are sorted."""
        return (self.file, self.line, self.column, self.code)
