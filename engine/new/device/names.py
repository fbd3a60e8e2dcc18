"""Names of actions, from names that stand in a tree: as short as they can be and still differ."""

import re
from collections import Counter
from collections.abc import Sequence

WIDTH = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|\W+")
STOPS = {
    "abort",
    "abort_all",
    "cancel_all",
    "emergency_stop",
    "halt",
    "stop",
    "stop_all",
    "stop_now",
}
"""What ends something, and may be done twice."""


def snake(name: str) -> str:
    """`TargetSpeed` -> `target_speed`."""
    found = re.sub(r"_+", "_", WIDTH.sub("_", name)).strip("_").lower()
    return f"_{found}" if found[:1].isdigit() else found or "_"


def short_names(paths: Sequence[Sequence[str]]) -> list[str]:
    """A name for each path: its last part, with as many of those before as it takes to differ."""
    lengths = [1] * len(paths)
    while True:
        names = [snake("_".join(p[-n:])) for p, n in zip(paths, lengths, strict=True)]
        counts = Counter(names)
        longer = [
            n + (counts[name] > 1 and n < len(p))
            for p, n, name in zip(paths, lengths, names, strict=True)
        ]
        if longer == lengths:
            break
        lengths = longer
    seen: Counter[str] = Counter()
    made = []
    for name in names:
        seen[name] += 1
        made.append(name if counts[name] == 1 else f"{name}_{seen[name]}")
    return made
