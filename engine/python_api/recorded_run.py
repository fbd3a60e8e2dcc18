"""A run as it lies in its folder: what it came to, its tables, spectra and journal."""

import html
from base64 import b64encode
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from ...schemas import journal as j
from ...schemas.labels import Labels
from ...schemas.model import first_fault
from ...schemas.quantity import is_quantity, quantity_text
from ...schemas.summary import Summary
from ...system.cells import bare
from ...system.extras import not_installed
from ..journal.encode import decode
from ..journal.journal import JournalFault, Records
from ..run.folder import JOURNAL, FolderFault, find_run
from ..run.labels import labelled, read_labels, write_labels
from ..run.rows import suffix
from ..run.summary import summary_of
from .faults import Refused

if TYPE_CHECKING:
    import pandas
    import xarray

    from ..index.comparison import Comparison
    from ..index.control_chart import Chart
    from ..index.entry import Entry

KEY = "key"


class RecordedRun:
    """One run's folder; nothing in it is changed. Shows itself in a notebook."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def id(self) -> str:
        """The name of its folder."""
        return self.folder.name

    @property
    def summary(self) -> Summary:
        """What it came to: fate, reason, points planned, measured, failed and left; read each time.

        Raises Refused where the journal cannot be read.
        """
        try:
            return summary_of(self.folder)
        except JournalFault as fault:
            raise Refused(f"{self.id}: {fault}") from None

    @property
    def fate(self) -> str:
        """succeeded, failed, aborted; interrupted if an engine has gone, running while one is there.

        `unreadable` is one that nobody can read, such as one that was killed before it began.
        """
        try:
            return self.summary.fate
        except Refused:
            return "unreadable"

    @property
    def journal(self) -> Records:
        """Every record, in order, read as it is iterated over."""
        return Records(self.folder / JOURNAL)

    @property
    def params(self) -> dict[str, Any]:
        """The values that the run began with, by name; quantities are pint's."""
        return next((decode(r.params) for r in self.journal.of("started")), {})  # type: ignore[union-attr]

    @property
    def outputs(self) -> dict[str, Any]:
        """What the protocol's `outputs` came to; {} where the run has not succeeded."""
        ends = list(self.journal.of("finished"))
        return decode(ends[-1].outputs) if ends else {}  # type: ignore[union-attr]

    @property
    def spectra(self) -> list[Path]:
        """The files in its folder `spectra`, by name."""
        return sorted((self.folder / "spectra").glob("*"))

    @property
    def report(self) -> Path | None:
        """The report for people, None if none was made."""
        path = self.folder / "report.html"
        return path if path.exists() else None

    @property
    def tables(self) -> list[str]:
        """The names that `table` takes."""
        return list(dict.fromkeys(r.file.removesuffix(".csv") for r in self._rows()))

    def table(self, name: str = "data") -> "pandas.DataFrame":
        """A loop's table, a row an iteration, indexed by its key; columns as in NAME.csv.

        `frame.attrs["units"]` has the unit of each column that has one. Raises Refused for a name
        that is none, and without pandas (the extra `notebook`).
        """
        pandas = _library("pandas")
        path = self.folder / f"{name}.csv"
        if not path.exists():
            there = ", ".join(self.tables) or "none"
            raise Refused(f"{self.id} has no table {name!r}; it has {there}")
        empty = ["", "nan"]  # not NA and None, which somebody may have written
        frame = pandas.read_csv(path, dtype={KEY: str}, keep_default_na=False, na_values=empty)
        for column in frame.columns[frame.dtypes.map(pandas.api.types.is_string_dtype)]:
            frame[column] = frame[column].map(
                lambda cell: bare(cell) if isinstance(cell, str) else cell
            )
        frame = frame.set_index(KEY)
        units = self._units(path.name)
        frame.attrs["units"] = {column + suffix(unit): unit for column, unit in units.items()}
        return frame

    def dataset(self, name: str = "data") -> "xarray.Dataset":
        """The table with names without units, along `key`; each variable's unit is its attribute `units`.

        Raises as `table` does (xarray is in the extra `notebook`, too).
        """
        _library("xarray")
        frame = self.table(name)
        units = frame.attrs["units"]
        plain = {column: column.removesuffix(suffix(unit)) for column, unit in units.items()}
        made = frame.rename(columns=plain).to_xarray()
        for column, unit in units.items():
            made[plain[column]].attrs["units"] = unit
        made.attrs.update(run=self.id, protocol=self.summary.protocol, fate=self.fate)
        return made

    @property
    def labels(self) -> Labels:
        """Sample, tags and note that people have given it."""
        return read_labels(self.folder)

    def label(
        self, *, sample: str | None = None, tags: Iterable[str] = (), note: str | None = None
    ) -> Labels:
        """Give it a sample, tags (`-word` removes one) or a note; raises Refused, OSError."""
        try:
            made = labelled(self.labels, sample=sample, tags=tags, note=note)
        except ValidationError as fault:
            raise Refused(first_fault(fault)) from None
        write_labels(self.folder, made)
        return made

    def _rows(self) -> Iterator[j.IterationEnded]:
        return (r for r in self.journal.of("iteration") if r.row is not None)  # type: ignore[union-attr,misc]

    def _units(self, file: str) -> dict[str, str]:
        """The unit of each column's first quantity."""
        found: dict[str, str] = {}
        for record in self._rows():
            if record.file != file:
                continue
            for name, value in decode(record.row).items():
                if name not in found and is_quantity(value):
                    found[name] = f"{value.units:~}"
        return {name: unit for name, unit in found.items() if unit}

    def __repr__(self) -> str:
        fate = self.fate
        word = fate if fate == "unreadable" else j.ended_as(fate, self.summary.holes)
        return f"<labrun run {self.id}: {word}>"

    def _repr_html_(self) -> str:
        summary = self.summary
        ended = j.ended_as(summary.fate, summary.holes)
        lines = [
            ("protocol", summary.protocol),
            ("ended", f"{ended}: {summary.reason}" if summary.reason else ended),
            ("points", summary.points.words(summary.holes)),
            *((name, _text(value)) for name, value in self.outputs.items()),
            ("folder", str(self.folder)),
        ]
        cells = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
            f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
            for name, text in lines
            if text
        )
        figures = "".join(
            f"<img alt='{html.escape(path.stem)}' style='max-width:100%' "
            f"src='data:image/png;base64,{b64encode(path.read_bytes()).decode()}'>"
            for path in sorted(self.folder.glob("*.png"))
        )
        return f"<table><caption>{html.escape(self.id)}</caption>{cells}</table>{figures}"


def _text(value: Any) -> str:
    return quantity_text(value) if is_quantity(value) else str(value)


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as fault:
        raise Refused(not_installed(fault, "notebook") or str(fault)) from None


def load(run: str | Path = "last", runs: str | Path = "runs") -> RecordedRun:
    """A run by its folder, its name, or an end of its name; `last` is the newest. Raises Refused."""
    try:
        return RecordedRun(find_run(Path(runs), str(run)))
    except FolderFault as fault:
        raise Refused(str(fault)) from None


def runs(folder: str | Path = "runs", *, find: str = "") -> list[RecordedRun]:
    """The runs in a folder, oldest first; those that `labrun runs --find` lists. Raises Refused."""
    return [RecordedRun(Path(folder) / entry.run) for entry in _found(folder, find)]


def compare(*names: str | Path | RecordedRun, runs: str | Path = "runs") -> "Comparison":
    """Two to eight runs beside each other, as `labrun compare` shows them; `print` it. Raises Refused."""
    from ..index.comparison import MOST, compare_runs

    if not 2 <= len(names) <= MOST:
        raise Refused(f"name two to {MOST} runs")
    there = [one if isinstance(one, RecordedRun) else load(one, runs) for one in names]
    return compare_runs([one.folder for one in there])


def values(
    name: str, runs: str | Path = "runs", *, find: str = "",
    low: float | str = "", high: float | str = "",
) -> "Chart":  # fmt: skip
    """A number over runs with its limits: an output, a parameter, or the mean of TABLE.COLUMN.

    low, high: limits of one's own, `"0.5 mm"` or a number in its unit; either alone, or computed
    ones for neither. Raises Refused where no run has it, and says which numbers there are.
    """
    from ..index.control_chart import chart, none_has
    from ..index.wanted import NotUnderstood

    entries = _found(runs, find)
    try:
        made = chart(entries, name, str(low), str(high))
    except NotUnderstood as fault:
        raise Refused(str(fault)) from None
    if not made.points:
        raise Refused(none_has(entries, name))
    return made


def _found(folder: str | Path, find: str) -> "list[Entry]":
    from ..index.index import find_runs
    from ..index.wanted import NotUnderstood

    try:
        return find_runs(Path(folder), find)
    except NotUnderstood as fault:
        raise Refused(str(fault)) from None
