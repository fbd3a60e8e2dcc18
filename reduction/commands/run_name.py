"""A run by its name, as `labrun resume` and the other commands take it."""

from pathlib import Path

RUNS = Path("runs")
JOURNAL = "journal.jsonl"


def or_run(path: Path) -> Path:
    """The path; where nothing lies there, the run in `runs` by its name, the end of it, or `last`."""
    if path.exists() or len(path.parts) != 1:
        return path
    journals = sorted(RUNS.glob(f"*/{JOURNAL}"), key=lambda journal: journal.stat().st_mtime_ns)
    found = [journal.parent for journal in journals]
    fitting = (
        found[-1:] if path.name == "last" else [f for f in found if f.name.endswith(path.name)]
    )
    return fitting[0] if len(fitting) == 1 else path
