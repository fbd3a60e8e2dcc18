"""The lines that the benchmark prints."""

import statistics
from typing import Any

WIDTH = 40


def median_ms(seconds: list[float]) -> float:
    """The median, in milliseconds."""
    return 1000 * statistics.median(seconds)


def show_head() -> None:
    print(f"  {'':<{WIDTH}}median ms   half of all lay in")


def show_times(name: str, seconds: list[float]) -> None:
    """The median of these times, and the range of the middle half."""
    low, _, high = (1000 * q for q in statistics.quantiles(seconds, n=4))
    print(f"  {name:<{WIDTH}}{median_ms(seconds):9.3f}   {low:.3f} .. {high:.3f}")


def show(name: str, value: float, words: str = "") -> None:
    """One computed figure, with a remark."""
    print(f"  {name:<{WIDTH}}{value:9.3f}   {words}".rstrip())


def show_bluesky(said: dict[str, Any], durable_ms: float, neither_ms: float) -> None:
    """A point of bluesky, whole and divided, and an action of ours beside a device action."""
    if absent("bluesky grid_scan", said, "pip install bluesky ophyd"):
        return
    point = median_ms(said["seconds"])
    action = point / said["actions"]
    show_times("bluesky grid_scan, a point", said["seconds"])
    show("  a message", point / said["messages"], f"{said['messages']:.1f} messages a point")
    show("  a device action", action, f"{said['actions']:.1f} `set` and `trigger` a point")
    show("  a durable action / a device action", durable_ms / action)
    show("  neither fsynced / a device action", neither_ms / action)
    print(f"    {said['versions']}; one process, no wire, nothing kept on disk")


def show_dbos(said: dict[str, Any], durable_ms: float) -> None:
    """A step of DBOS, and an action of ours beside it."""
    if absent("DBOS workflow", said, "pip install dbos"):
        return
    show_times("DBOS workflow, a step", said["seconds"])
    show("  a durable action / a step", durable_ms / median_ms(said["seconds"]))
    print(f"    {said['versions']}; one process, no wire; SQLite with {said['kept']}")


def absent(name: str, said: dict[str, Any], command: str) -> bool:
    """Report a library that could not be measured."""
    if "missing" in said:
        print(f"  {name:<{WIDTH}}not installed: {command}   ({said['missing']})")
    elif "failed" in said:
        print(f"  {name:<{WIDTH}}failed: {said['failed']}")
    return "seconds" not in said
