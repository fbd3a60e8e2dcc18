"""What a person in Python is told instead of a result: a sentence, without a traceback in a notebook."""

from collections.abc import Iterable

from ...schemas.problem import Problem
from ..language.source import Source
from .problems import Problems


class Refused(Exception):
    """What was asked for cannot be done; the text says why, and what now."""

    def _render_traceback_(self) -> list[str]:
        """What IPython shows of it: where in labrun's own code it was raised helps nobody."""
        return str(self).splitlines()


class NoSuch(Refused, AttributeError):
    """A device or an action that is not there; Python wants an AttributeError of an attribute."""


class ActionFailed(Refused):
    """A device could not do what it was asked; the text is the device's, with its action and error."""


class ProtocolFault(Refused, ValueError):
    """A protocol with errors; the text is what `labrun check` prints, `problems` are its parts."""

    def __init__(self, problems: Iterable[Problem], source: Source | None) -> None:
        self.problems = Problems(problems, source)
        super().__init__(str(self.problems))
