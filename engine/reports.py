"""Reports and figures of a run: made by whoever registered as `labrun.reports`."""

from importlib.metadata import entry_points
from pathlib import Path


def make_reports(folder: Path) -> tuple[list[Path], list[str]]:
    """Let every report maker have the run's folder; a maker that fails is a line, not a fault."""
    made: list[Path] = []
    failed: list[str] = []
    for point in sorted(entry_points(group="labrun.reports"), key=lambda point: point.name):
        try:
            made.extend(point.load()(folder))
        except Exception as fault:  # a plug-in's fault must not cost the run its end
            failed.append(f"report {point.name!r} was not made: {type(fault).__name__}: {fault}")
    return made, failed
