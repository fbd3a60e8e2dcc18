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
from .options import WrongUsage, pairs, say


def checked_file(
    file: Path, lab: Path | None, bind: list[str] | None, param: list[str] | None,
    *, needed: bool = True, json: bool = False,
) -> Checked:  # fmt: skip
    """The checked protocol; problems go to stderr, and an error ends the command with status 2."""
    roles, params = name_values(bind, "--bind"), name_values(param, "-p")
    checked = check_file(file, lab=lab, bind=roles, params=params, needed=needed)
    if checked.problems:
        print_problems(checked.problems, format="json" if json else "text", file=sys.stderr)
    if not checked.ok:
        raise typer.Exit(PROBLEMS)
    return checked


def name_values(texts: list[str] | None, option: str) -> dict[str, str]:
    """`NAME=VALUE` options as a dictionary; one in another form ends the command."""
    try:
        return pairs(texts, option)
    except WrongUsage as fault:
        say(str(fault))
        raise typer.Exit(PROBLEMS) from None


def fitting_answers(texts: list[str] | None, checked: Checked) -> dict[str, str]:
    """`--answer ID=CHOICE` as a dictionary; one that no question could take ends the command."""
    answers = name_values(texts, "--answer")
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
            say(f"--answer {name}={choice}: no step has the id {name!r}{did_you_mean(name, ids)}")
            raise typer.Exit(PROBLEMS)
        if asked and choice not in choices:
            guess = did_you_mean(choice, choices)
            say(
                f"--answer {name}={choice}: {choice!r} is not among {listed(sorted(choices))}{guess}"
            )
            raise typer.Exit(PROBLEMS)
    return answers


def _all_surveys(survey: Survey) -> Iterator[Survey]:
    yield survey
    for used in survey.used.values():
        yield from _all_surveys(used.survey)
