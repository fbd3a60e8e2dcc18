"""What commands of the reduction say, and how they read lists."""

import typer

FAILED, PROBLEMS = 1, 2  # exit status: something could not be written; wrong usage or input


def say(text: str) -> None:
    """One line to a person, beside what a program reads from stdout."""
    typer.echo(f"labrun: {text}", err=True)


def listed(text: str) -> tuple[str, ...]:
    """`Li, K,Si` as its parts, each once."""
    return tuple(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))
