"""Ask the one checker and its views about a text, in a process that can be ended."""

from pathlib import Path
from typing import Any, TypeVar

from ...engine.lab import load_lab
from ...engine.lab_schema.schema import lab_schema
from ...schemas.problem import Problem
from ..guard.refusal import Refusal
from ..models.protocols import CheckedText, CheckText, Explained, Graph, Preview, Words
from ..models.told import FoundProblem, Told
from ..workers import Worker

LONGEST_S = 20.0
T = TypeVar("T", bound=Told)


class Looking:
    """Checks texts as if they lay in `folder`, against the lab of the command line."""

    def __init__(self, worker: Worker, folder: Path, lab_file: Path | None, timings: Path) -> None:
        self._worker = worker
        self._lab_file = lab_file
        self._place = {
            "folder": str(folder), "lab": str(lab_file) if lab_file is not None else None,
            "timings": str(timings),
        }  # fmt: skip

    async def check(self, asked: CheckText) -> CheckedText:
        """All that is wrong with a text, and the form with which it would be started."""
        return await self._look("check", asked, CheckedText)

    async def for_a_run(self, asked: CheckText) -> CheckedText:
        """Checked with all its parameters needed; raises Refusal with the problems."""
        return await self._look("start", asked, CheckedText)

    async def words(self, asked: CheckText) -> Words:
        """The protocol in plain sentences."""
        return await self._look("words", asked, Words)

    async def explain(self, asked: CheckText) -> Explained:
        """P = [A1, ..., AT]."""
        return await self._look("explain", asked, Explained)

    async def graph(self, asked: CheckText) -> Graph:
        """The tree."""
        return await self._look("graph", asked, Graph)

    async def preview(self, asked: CheckText) -> Preview:
        """Points, actions, time."""
        return await self._look("preview", asked, Preview)

    def schema(self) -> dict[str, Any]:
        """The JSON Schema of protocols for the lab as its file is now."""
        lab, problems = load_lab(self._lab_file)
        if lab is None:
            raise Refusal(422, "LAB", "the lab's file has problems", problems=_plain(problems))
        return lab_schema(lab)

    async def _look(self, view: str, asked: CheckText, kind: type[T]) -> T:
        text = asked.model_dump(include=set(CheckText.model_fields))
        told = {**self._place, "view": view, "text": text}
        return kind.model_validate(await self._worker.ask("look", told, LONGEST_S))


def _plain(problems: list[Problem]) -> list[FoundProblem]:
    return [
        FoundProblem(
            file=p.file, line=p.line, column=p.column, length=p.length, severity=p.severity,
            code=p.code, message=p.message, hint=p.hint,
        )
        for p in problems
    ]  # fmt: skip
