"""Run the checker and its views on a text, in a process that can be killed."""

from pathlib import Path
from typing import Any, Literal, TypeVar

from ...engine.lab.lab import load_lab
from ...engine.lab_schema.schema import lab_schema
from ..local.refusal import Refusal
from ..local.workers import Worker
from ..models.base import ApiModel, FoundProblem
from ..models.protocols import CheckedText, CheckText

View = Literal["check", "start", "words", "explain", "preview"]
T = TypeVar("T", bound=ApiModel)


class TextCheck:
    """Checks texts as if they were in `folder`, against the lab of the command line."""

    def __init__(
        self,
        worker: Worker,
        folder: Path,
        lab_file: Path | None,
        timings: Path,
        *,
        timeout_s: float,
    ) -> None:
        self._worker = worker
        self._timeout_s = timeout_s
        self._lab_file = lab_file
        self._place = {
            "folder": str(folder), "lab": str(lab_file) if lab_file is not None else None,
            "timings": str(timings),
        }  # fmt: skip

    async def check(self, asked: CheckText) -> CheckedText:
        """All problems of a text, and the form with which it would be started."""
        return await self.view("check", asked, CheckedText)

    async def for_a_run(self, asked: CheckText) -> CheckedText:
        """Check with all parameters required; raises Refusal with the problems."""
        return await self.view("start", asked, CheckedText)

    def schema(self) -> dict[str, Any]:
        """The JSON Schema of protocols for the present lab file."""
        lab, problems = load_lab(self._lab_file)
        if lab is None:
            plain = [FoundProblem.of(problem) for problem in problems]
            raise Refusal(422, "LAB", "the lab's file has problems", problems=plain)
        return lab_schema(lab)

    async def view(self, view: View, asked: CheckText, kind: type[T]) -> T:
        """One view of a text; raises Refusal with its problems if they are in the way."""
        text = asked.model_dump(include=set(CheckText.model_fields))
        told = {**self._place, "view": view, "text": text}
        return kind.model_validate(await self._worker.ask("look", told, self._timeout_s))
