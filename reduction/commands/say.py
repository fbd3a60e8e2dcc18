"""One line to the user, and the exit statuses of these commands."""

import sys

FAILED, PROBLEMS, PARTLY, NOT_REACHED, CTRL_C, TERMINATED = 1, 2, 3, 4, 130, 143


def say(text: str) -> None:
    """Print to stderr; stdout is for what a program reads."""
    print(f"labrun: {text}", file=sys.stderr, flush=True)
