"""Reports and figures of a run: made by the plug-ins registered as `labrun.reports`."""

import logging
from importlib.metadata import entry_points
from pathlib import Path

from ...system.extras import in_words
from ...system.files import REFUSED

LOG = logging.getLogger("labrun")


def make_reports(folder: Path) -> tuple[list[Path], list[str]]:
    """Call every report maker with the run's folder; one that fails is reported in a line."""
    made: list[Path] = []
    failed: list[str] = []
    for point in sorted(entry_points(group="labrun.reports"), key=lambda point: point.name):
        try:
            made.extend(point.load()(folder))
        except Exception as fault:  # a plug-in's fault must not stop the run from ending
            words = in_words(fault)
            if isinstance(fault, OSError) and fault.errno in REFUSED:
                words = f"{folder}: {fault.strerror}"
            elif not isinstance(fault, ImportError):
                LOG.exception("report %r", point.name)
            failed.append(f"report {point.name!r} was not made: {words}")
    return made, failed
