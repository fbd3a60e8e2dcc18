"""Check a protocol against what its lab's devices can do; report every problem, raise none."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..schemas.problem import Problem
from ..schemas.protocol import Protocol
from ..system.start import collector_at_rest
from .checks import (
    arguments,
    calculations,
    columns,
    doubles,
    endless,
    errors,
    fallbacks,
    given,
    hazards,
    ids,
    loops,
    names,
    never_runs,
    overlap,
    overwritten,
    own_functions,
    paths,
    reach,
    references,
    repeats,
    retries,
    sent_files,
    sets,
    syntax,
    texts,
    timeouts,
    tolerance,
    unused,
    uses,
    watching,
)  # fmt: skip
from .checks.context import Context
from .lab.bind import BoundRole, bind_roles
from .lab.lab import LoadedLab, load_lab
from .language.load import Loaded, read_protocol
from .language.source import Source, parse_source, read_source
from .params.params import read_params
from .survey.survey import Survey
from .survey.used import Opener

CHECKS = (
    names, arguments, paths, sent_files, errors, uses,
    syntax, references, calculations, own_functions,
    ids, sets, watching, overlap, loops, columns, reach, fallbacks,
    given, never_runs, endless, timeouts, repeats, retries, tolerance,
    hazards, overwritten, doubles, texts, unused,
)  # fmt: skip
"""Each has CODES, a docstring that is its page of the manual, and check(context)."""


HIDING = ("E1", "E208", "E209", "E21", "E22")
"""What hides the meaning of a protocol: its shape, its devices, its parameters."""
READINGS = {"W101", "W102", "W103", "W104", "W105"}
"""Warnings that a value is not read as it looks."""


@dataclass
class Checked:
    """A protocol with everything that a run needs, as far as it is valid."""

    source: Source | None = None
    protocol: Protocol | None = None
    lab: LoadedLab | None = None
    roles: dict[str, BoundRole] = field(default_factory=dict)
    params: dict[str, Any] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    survey: Survey | None = None

    @property
    def understood(self) -> bool:
        """True when no error hides what the protocol means; points outside the bench hide nothing."""
        errors = [p.code for p in self.problems if p.severity == "error"]
        return self.protocol is not None and not any(code.startswith(HIDING) for code in errors)

    @property
    def ok(self) -> bool:
        """True when there are no errors; warnings do not stop a run."""
        return self.protocol is not None and not any(p.severity == "error" for p in self.problems)


def check_file(
    path: Path, *, lab: Path | None = None, bind: Mapping[str, str] | None = None,
    params: Mapping[str, Any] | None = None, needed: bool = True,
) -> Checked:  # fmt: skip
    """Check the protocol in a file.

    `params` are texts as on the command line, or values. `needed=False`: a parameter without a
    value is only a warning, for a check without a run.
    """
    with collector_at_rest():
        source, problems = read_source(path)
        return _check(source, problems, lab, bind or {}, params or {}, needed)


def check_text(
    text: str, name: str, *, lab: Path | None = None, bind: Mapping[str, str] | None = None,
    params: Mapping[str, Any] | None = None, needed: bool = False,
) -> Checked:  # fmt: skip
    """Check a protocol that is not in a file, such as an editor's text; `name` is shown."""
    with collector_at_rest():
        source, problems = parse_source(text, Path(name), name)
        return _check(source, problems, lab, bind or {}, params or {}, needed)


def _check(
    source: Source | None, problems: list[Problem], lab: Path | None, bind: Mapping[str, str],
    params: Mapping[str, Any], needed: bool,
) -> Checked:  # fmt: skip
    checked = Checked(source=source)
    checked.lab, more = load_lab(lab)
    problems = [*problems, *more]
    loaded: Loaded | None = None
    if source is not None:
        loaded, more = read_protocol(source)
        problems += more
    if source is not None and loaded is not None:
        checked.protocol = loaded.protocol
        problems += _mean(checked, source, bind, params, needed, loaded)
    checked.problems = in_order(problems, source)
    return checked


def _mean(
    checked: Checked,
    source: Source,
    bind: Mapping[str, str],
    params: Mapping[str, Any],
    needed: bool,
    loaded: Loaded,
) -> list[Problem]:
    """The problems in a protocol's meaning: roles, parameters, and all the checks."""
    protocol = checked.protocol
    assert protocol is not None
    problems: list[Problem] = []
    if checked.lab is not None:
        checked.roles, problems = bind_roles(protocol.devices, checked.lab, bind, source)
    checked.params, more = read_params(protocol.params, params, source, needed=needed)
    problems += more
    shared = checked.lab.folders if checked.lab is not None else ()
    opening = Opener((source.path.parent, *shared))
    opened = opening.open(source, loaded)
    checked.survey = Survey(opened, checked.roles, checked.params)
    return [*problems, *opening.problems, *_found(checked.survey, checked.lab)]


def _found(survey: Survey, lab: LoadedLab | None, *, used: bool = False) -> Iterator[Problem]:
    """Everything the checks find in a protocol and in those that it uses."""
    context = Context(
        survey.source, survey.protocol, lab, survey.roles, survey, survey.opened.loaded.whole, used
    )
    for family in CHECKS:
        yield from family.check(context)
    for inner in survey.used.values():
        yield from _found(inner.survey, lab, used=True)


def in_order(problems: list[Problem], source: Source | None) -> list[Problem]:
    """Problems sorted by place, without duplicates, those of the protocol itself first.

    How a value looks is not told where an error is told of it, nor what follows from a number that is none.
    """
    name = source.name if source is not None else ""
    wrong = {problem.place[:3] for problem in problems if problem.severity == "error"}
    unread = {problem.place[:3] for problem in problems if problem.code == "E106"}
    unique = {
        (*problem.place, problem.message): problem
        for problem in problems
        if not (problem.code in READINGS and problem.place[:3] in wrong)
        and (problem.code == "E106" or problem.place[:3] not in unread)
    }
    return sorted(unique.values(), key=lambda problem: (problem.file != name, problem.place))
