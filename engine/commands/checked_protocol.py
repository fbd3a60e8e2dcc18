"""Check a protocol file for a command: problems are shown, and an error ends the command."""

import sys
from collections.abc import Iterator
from pathlib import Path

import typer

from ...schemas.protocol import CONFIRM_CHOICES, Ask, Confirm
from ..check import Checked, check_file
from ..exit_status import PROBLEMS
from ..language.suggest import did_you_mean, listed
from ..problems.print import print_problems
from ..survey.survey import Survey
from .options import fail, pairs


def checked_file(
    file: Path, lab: Path | None, bind: list[str] | None, param: list[str] | None,
    *, needed: bool = True, json: bool = False, as_far_as_understood: bool = False,
) -> Checked:  # fmt: skip
    """The checked protocol; problems go to stderr, and an error ends the command with status 2.

    `as_far_as_understood`: only an error that hides what the protocol means does so.
    """
    roles, params = pairs(bind, "--bind"), pairs(param, "-p")
    checked = check_file(file, lab=lab, bind=roles, params=params, needed=needed)
    if checked.problems:
        print_problems(checked.problems, format="json" if json else "text", file=sys.stderr)
    if not (checked.understood if as_far_as_understood else checked.ok):
        raise typer.Exit(PROBLEMS)
    return checked


def fitting_answers(texts: list[str] | None, checked: Checked) -> dict[str, str]:
    """`--answer ID=CHOICE` as a dictionary; one that no question could take ends the command."""
    answers = pairs(texts, "--answer")
    assert checked.survey is not None
    steps = [at.step for survey in _all_surveys(checked.survey) for at in survey.steps]
    ids = {step.id for step in steps if step.id is not None}
    for name, choice in answers.items():
        asked = [step for step in steps if step.id == name and isinstance(step, Ask | Confirm)]
        choices = {
            one
            for step in asked
            for one in (step.choices if isinstance(step, Ask) else CONFIRM_CHOICES)
        }
        if name not in ids and not name.isdigit():
            fail(f"--answer {name}={choice}: no step has the id {name!r}{did_you_mean(name, ids)}")
        if asked and choice not in choices:
            guess = did_you_mean(choice, choices)
            fail(
                f"--answer {name}={choice}: {choice!r} is not among {listed(sorted(choices))}{guess}"
            )
    return answers


def _all_surveys(survey: Survey) -> Iterator[Survey]:
    yield survey
    for used in survey.used.values():
        yield from _all_surveys(used.survey)
