"""Ask the one checker and its views about a text, in a thread of their own."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from ...engine.check import Checked, check_text
from ...engine.lab import LoadedLab, load_lab
from ...engine.lab_schema.schema import lab_schema
from ...schemas.problem import Problem
from ..guard.refusal import Refusal
from ..models.protocols import CheckedText, CheckText, Explained, Graph, Preview, Words
from ..models.told import FoundProblem
from .form import hazards_of, params_of, questions_of, roles_of
from .names import wrong_name
from .pointer import pointer_of
from .sight import graph_of, preview_of, words_of
from .timings import Timings

MOST_PROBLEMS = 500
STOPPING = ("E1", "E208", "E209", "E21", "E22")
"""What hides the meaning of a protocol; points outside the bench do not."""
T = TypeVar("T")


class Looking:
    """Checks texts as if they lay in `folder`, against the lab of the command line."""

    def __init__(
        self, folder: Path, lab_file: Path | None, lab: LoadedLab, timings: Timings
    ) -> None:
        self._folder = folder
        self._lab_file = lab_file
        self._lab = lab
        self._timings = timings
        # One at a time: the checker puts the collector of garbage to rest while it works.
        self._thread = ThreadPoolExecutor(1, "check")

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown(wait=True, cancel_futures=True)

    async def check(self, asked: CheckText) -> CheckedText:
        """All that is wrong with a text, and the form with which it would be started."""
        return await self._apart(lambda: self._told(asked, self.checked(asked)))

    async def summary(self, asked: CheckText) -> tuple[CheckedText, Checked]:
        """The same, with what the checker knows."""

        def look() -> tuple[CheckedText, Checked]:
            checked = self.checked(asked)
            return self._told(asked, checked), checked

        return await self._apart(look)

    async def for_a_run(self, asked: CheckText) -> Checked:
        """Checked with all its parameters needed; raises Refusal with the problems."""
        return await self._apart(lambda: self._sound(asked, needed=True))

    def schema(self) -> dict[str, Any]:
        """The JSON Schema of protocols for the lab as its file is now."""
        lab, problems = load_lab(self._lab_file)
        if lab is None:
            raise Refusal(422, "LAB", "the lab's file has problems", problems=_plain(problems))
        return lab_schema(lab)

    async def words(self, asked: CheckText) -> Words:
        """The protocol in plain sentences."""
        return await self._apart(lambda: words_of(self._sound(asked)))

    async def explain(self, asked: CheckText) -> Explained:
        """P = [A1, ..., AT]."""
        from ...engine.views.explain import explain_protocol

        return await self._apart(
            lambda: Explained(lines=list(explain_protocol(self._sound(asked))))
        )

    async def graph(self, asked: CheckText) -> Graph:
        """The tree."""
        return await self._apart(lambda: graph_of(self._sound(asked)))

    async def preview(self, asked: CheckText) -> Preview:
        """Points, actions, time."""
        return await self._apart(lambda: preview_of(self._readable(asked), self._timings))

    def checked(self, asked: CheckText, *, needed: bool = False) -> Checked:
        """What the checker knows of a text."""
        return check_text(
            asked.text, str(self._name(asked)), lab=self._lab_file, bind=asked.bind,
            params=asked.params, needed=needed,
        )  # fmt: skip

    def found(self, checked: Checked) -> list[FoundProblem]:
        """The problems of a check, each with its pointer; files are named from the folder."""
        return [self._problem(problem, checked) for problem in checked.problems[:MOST_PROBLEMS]]

    def _name(self, asked: CheckText) -> Path:
        why = wrong_name(asked.name)
        if why:
            raise Refusal(422, "WRONG_NAME", f"{asked.name[:80]!r} is no name: {why}")
        return self._folder / asked.name

    def _told(self, asked: CheckText, checked: Checked) -> CheckedText:
        protocol = checked.protocol
        return CheckedText(
            ok=checked.ok, revision=sha256(asked.text.encode(errors="replace")).hexdigest(),
            title=protocol.name if protocol is not None else None, problems=self.found(checked),
            params=params_of(protocol), roles=roles_of(checked),
            hazards=hazards_of(checked), questions=questions_of(protocol),
        )  # fmt: skip

    def _sound(self, asked: CheckText, *, needed: bool = False) -> Checked:
        checked = self.checked(asked, needed=needed)
        if not checked.ok:
            raise self._refused(checked)
        return checked

    def _readable(self, asked: CheckText) -> Checked:
        checked = self.checked(asked)
        stopped = any(
            p.severity == "error" and p.code.startswith(STOPPING) for p in checked.problems
        )
        if stopped or checked.protocol is None or checked.survey is None:
            raise self._refused(checked)
        return checked

    def _refused(self, checked: Checked) -> Refusal:
        problems = self.found(checked)
        errors = sum(problem.severity == "error" for problem in problems)
        words = "1 error" if errors == 1 else f"{errors} errors"
        return Refusal(422, "PROBLEMS", f"the protocol has {words}", problems=problems)

    def _problem(self, problem: Problem, checked: Checked) -> FoundProblem:
        file = problem.file
        path = Path(file)
        if path.is_absolute() and path.is_relative_to(self._folder):
            file = path.relative_to(self._folder).as_posix()
        pointer = pointer_of(checked.source, problem) if checked.source is not None else None
        return FoundProblem(
            file=file, line=problem.line, column=problem.column, length=problem.length,
            severity=problem.severity, code=problem.code, message=problem.message,
            hint=problem.hint, pointer=pointer,
        )  # fmt: skip

    async def _apart(self, look: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._thread, look)


def _plain(problems: list[Problem]) -> list[FoundProblem]:
    return [
        FoundProblem(
            file=p.file, line=p.line, column=p.column, length=p.length, severity=p.severity,
            code=p.code, message=p.message, hint=p.hint,
        )
        for p in problems
    ]  # fmt: skip
