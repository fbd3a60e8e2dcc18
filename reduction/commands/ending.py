"""Print the summary of a reduction: what was found, what failed, where the tables are."""

from pathlib import Path
from statistics import median

from rich.console import Console
from rich.table import Table

from ..batch.summary import Circumstances, Counts

MOST_ELEMENTS = 12
MOST_FAILED = 5
MOST_NOTES = 4


def tell_ending(counts: Counts, about: Circumstances, out: Path, made: list[Path]) -> None:
    """Print the short summary to stdout."""
    console = Console(highlight=False)
    console.print(_elements(counts))
    console.print(
        f"{counts.reduced:,} spectra reduced, {counts.peaks:,} peaks, {about.seconds:.1f} s "
        f"({about.rate(counts.spectra):.0f}/s, {about.workers})", markup=False,
    )  # fmt: skip
    if counts.temperatures_k:
        console.print(f"median temperature {median(counts.temperatures_k):,.0f} K")
    if counts.failed:
        console.print(f"{len(counts.failed):,} could not be reduced:", style="red")
        for name, reason in counts.failed[:MOST_FAILED]:
            console.print(f"  {name}: {reason}", markup=False, soft_wrap=True)
        if len(counts.failed) > MOST_FAILED:
            console.print(f"  and {len(counts.failed) - MOST_FAILED:,} more, in files.csv")
    for note, names in list(counts.notes.items())[:MOST_NOTES]:
        which = names[0] if len(names) == 1 else f"{len(names):,} spectra"
        console.print(f"note: {which}: {note}", markup=False, soft_wrap=True)
    if len(counts.notes) > MOST_NOTES:
        console.print(f"  and {len(counts.notes) - MOST_NOTES:,} more notes, in files.csv")
    for path in made:
        console.print(f"wrote {path}", markup=False, soft_wrap=True)
    console.print(f"the tables are in {out}", markup=False, soft_wrap=True)


def _elements(counts: Counts) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("element", style="bold")
    table.add_column("detected in", justify="right")
    table.add_column("uncertain in", justify="right")
    symbols = sorted(
        {*counts.detected, *counts.uncertain},
        key=lambda name: (-counts.detected[name], -counts.uncertain[name], name),
    )
    for name in symbols[:MOST_ELEMENTS]:
        table.add_row(name, f"{counts.detected[name]:,}", f"{counts.uncertain[name]:,}")
    if len(symbols) > MOST_ELEMENTS:
        table.caption = f"and {len(symbols) - MOST_ELEMENTS} more, in elements.csv"
    if not symbols:
        table.add_row("none", "", "")
    return table
