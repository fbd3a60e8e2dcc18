"""The checker and the views on a text, in the worker: a long text keeps a checker busy."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

from ...engine.check import Checked, check_text
from ...schemas.problem import Problem
from ..local.refusal import Refusal
from ..models.base import ApiModel, FoundProblem
from ..models.protocols import CheckedText, CheckText, Explained, Preview, Words
from .form import hazards_of, params_of, questions_of, roles_of
from .names import wrong_name
from .pointer import pointer_of
from .timings import Timings
from .views import preview_of, words_of

MOST_PROBLEMS = 500


class Eye:
    """Examines texts as if they were in `folder`, against a lab file."""

    def __init__(self, folder: Path, lab_file: Path | None, timings: Path) -> None:
        self._folder = folder
        self._lab_file = lab_file
        self._timings = timings

    def check(self, asked: CheckText, *, needed: bool = False) -> CheckedText:
        """Every problem, and the form with which it would be started."""
        checked = self._checked(asked, needed=needed)
        protocol = checked.protocol
        return CheckedText(
            ok=checked.ok, revision=sha256(asked.text.encode(errors="replace")).hexdigest(),
            title=protocol.name if protocol is not None else None,
            summary=protocol.summary if protocol is not None else "",
            problems=found_problems(checked, self._folder), params=params_of(protocol),
            roles=roles_of(checked), hazards=hazards_of(checked), questions=questions_of(checked),
        )  # fmt: skip

    def start(self, asked: CheckText) -> CheckedText:
        """The same for a text that is to be started now; raises Refusal with its problems."""
        told = self.check(asked, needed=True)
        if not told.ok:
            raise problems_refused(told.problems)
        return told

    def words(self, asked: CheckText) -> Words:
        """The protocol in plain sentences."""
        return words_of(self._sound(asked))

    def explain(self, asked: CheckText) -> Explained:
        """P = [A1, ..., AT]."""
        from ...engine.views.explain import explain_protocol

        return Explained(lines=list(explain_protocol(self._sound(asked))))

    def preview(self, asked: CheckText) -> Preview:
        """Points, actions, time; points outside the bench are accepted."""
        checked = self._checked(asked)
        if not checked.understood:
            raise problems_refused(found_problems(checked, self._folder))
        return preview_of(checked, Timings(self._timings))

    def _sound(self, asked: CheckText) -> Checked:
        checked = self._checked(asked)
        if not checked.ok:
            raise problems_refused(found_problems(checked, self._folder))
        return checked

    def _checked(self, asked: CheckText, *, needed: bool = False) -> Checked:
        why = wrong_name(asked.name)
        if why:
            raise Refusal(422, "WRONG_NAME", f"{asked.name[:80]!r} is not a valid name: {why}")
        return check_text(
            asked.text, str(self._folder / asked.name), lab=self._lab_file, bind=asked.bind,
            params=asked.params, needed=needed,
        )  # fmt: skip


VIEWS: dict[str, Callable[[Eye, CheckText], ApiModel]] = {
    "check": Eye.check, "start": Eye.start, "words": Eye.words, "explain": Eye.explain,
    "preview": Eye.preview,
}  # fmt: skip


def look(asked: dict[str, Any]) -> dict[str, Any]:
    """One view of one text; raises Refusal."""
    lab = Path(asked["lab"]) if asked["lab"] is not None else None
    eye = Eye(Path(asked["folder"]), lab, Path(asked["timings"]))
    return VIEWS[asked["view"]](eye, CheckText(**asked["text"])).model_dump(mode="json")


def found_problems(checked: Checked, folder: Path) -> list[FoundProblem]:
    """The problems of a check, each with its pointer; files are named from the folder."""
    return [_problem(problem, checked, folder) for problem in checked.problems[:MOST_PROBLEMS]]


def problems_refused(problems: list[FoundProblem], what: str = "the protocol") -> Refusal:
    """The refusal of a text with problems."""
    errors = sum(problem.severity == "error" for problem in problems)
    words = "1 error" if errors == 1 else f"{errors} errors"
    return Refusal(422, "PROBLEMS", f"{what} has {words}", problems=problems)


def _problem(problem: Problem, checked: Checked, folder: Path) -> FoundProblem:
    path = Path(problem.file)
    inside = path.is_absolute() and path.is_relative_to(folder)
    pointer = pointer_of(checked.source, problem) if checked.source is not None else None
    file = path.relative_to(folder).as_posix() if inside else problem.file
    return FoundProblem.of(problem, file=file, pointer=pointer)
