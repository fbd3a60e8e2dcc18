"""One line to a person, and the exit statuses of these commands."""

import sys

FAILED, PROBLEMS, NOT_REACHED, CTRL_C, TERMINATED = 1, 2, 4, 130, 143


def say(text: str) -> None:
    """Beside what a program reads from stdout."""
    print(f"labrun: {text}", file=sys.stderr, flush=True)
