"""A place in a ROS message: `x`, `pose.position.x`, `points[0].positions[2]`."""

import re
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

NAME = re.compile(r"([A-Za-z]\w*)((?:\[\d+\])*)")

FieldPath = tuple[str | int, ...]


def read_path(written: str) -> FieldPath:
    """The steps of a path; raises ValueError."""
    steps: list[str | int] = []
    for part in written.split("."):
        found = NAME.fullmatch(part)
        if found is None:
            raise ValueError(
                f"{written!r} is not a place in a message; write it as `pose.position.x` or "
                "`points[0].positions`"
            )
        steps += [found[1], *(int(index) for index in re.findall(r"\d+", found[2]))]
    return tuple(steps)


def put(message: Any, path: FieldPath, value: Any) -> None:
    """Set a value; lists on the way grow, with None where nothing has been put."""
    for step, following in pairwise(path):
        kind = list if isinstance(following, int) else dict
        _reach(message, step)
        if message[step] is None:
            message[step] = kind()
        message = message[step]
    _reach(message, path[-1])
    message[path[-1]] = value


def get(message: Any, path: FieldPath) -> Any:
    """The value there; None if there is none."""
    for step in path:
        if isinstance(step, int):
            if not isinstance(message, list) or step >= len(message):
                return None
            message = message[step]
        elif isinstance(message, Mapping):
            message = message.get(step)
        else:
            return None
    return message


def gap(message: Any, where: str = "") -> str | None:
    """The first place of a list that nothing was put into; None if there is none."""
    if isinstance(message, Mapping):
        found = (gap(one, f"{where}.{name}" if where else name) for name, one in message.items())
    elif isinstance(message, list):
        found = (gap(one, f"{where}[{index}]") for index, one in enumerate(message))
    else:
        return where if message is None else None
    return next((place for place in found if place is not None), None)


def _reach(message: Any, step: str | int) -> None:
    if isinstance(step, int):
        message.extend([None] * (step + 1 - len(message)))
    else:
        message.setdefault(step, None)
