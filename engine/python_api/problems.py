"""Problems as they show themselves: what `labrun check` prints, in a notebook too."""

import html
import io
from collections.abc import Iterable

from ...schemas.problem import Problem
from ..language.source import Source
from ..problems.print import print_problems

COLOURS = {"error": "#c0392b", "warning": "#b9770e"}


class Problems(list[Problem]):
    """Problems in the order of the file; each has file, line, column, severity, code, message, hint."""

    def __init__(self, problems: Iterable[Problem] = (), source: Source | None = None) -> None:
        super().__init__(problems)
        self._texts = {source.name: source.text} if source is not None else {}

    def __str__(self) -> str:
        text = io.StringIO()
        print_problems(self, file=text, texts=self._texts)
        return text.getvalue().rstrip("\n") or "no problems"

    __repr__ = __str__

    def _repr_html_(self) -> str:
        text = html.escape(str(self), quote=False)
        for severity, colour in COLOURS.items():
            mark = f"{severity}["
            text = text.replace(f": {mark}", f": <b style='color:{colour}'>{severity}</b>[")
        return f"<pre>{text}</pre>"


class Check:
    """What a check has found: `ok` without errors (warnings stop no run), and the `problems`."""

    def __init__(self, problems: Problems, *, ok: bool) -> None:
        self.problems, self.ok = problems, ok

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        return str(self.problems)

    def _repr_html_(self) -> str:
        return self.problems._repr_html_()
