"""Report chapters on what the run produced: figures, tables, every file, and the versions."""

import csv
from base64 import b64encode
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from ...engine.run.folder import JOURNAL
from ...system.cells import bare
from .files import CRATE, PAGE, KeptFile, look
from .formatting import count, size, value
from .html import Html, at_time, code, folded, join, paragraph, section, table, tag, text
from .report_data import ReportData

ROWS_SHOWN = 12
CHECKS = "checks.csv"
"""What check standards say of a calibration: made from the rows, and as worth reading."""
CELL_SHOWN = 200
FIGURE_SHOWN = 4_000_000
LISTED_OPEN = 8
"""A folder with more files than this is collapsed in the list."""
MANY = 200
"""A folder up to this size stays expanded if one of its files is not as the run wrote it."""


def figures(title: str, data: ReportData) -> Html:
    """The figures, embedded in the page."""
    return section("figures", title, *(_figure(data, file) for file in data.figures))


def snapshots(title: str, data: ReportData) -> Html:
    """Pictures that people took of the bench; they are not what the protocol measured."""
    files, left, shown = {file.path: file for file in data.inventory.files}, FIGURE_SHOWN, []
    for one in data.snapshots:
        file = files.get(one.file) or look(data.folder, one.file)
        caption = tag(
            "figcaption", f"{one.device}, ", at_time(one.at), f", by {one.by}" if one.by else "",
            " (", code(one.file), ")",
            tag("span", ": changed since it was taken", class_="bad") if file.sha256 != one.sha256 else "",
        )  # fmt: skip
        left -= file.size
        shown.append(_picture(data, file, caption, f"Taken with {one.device}", left > 0))
    return section("snapshots", title, *shown)


def _figure(data: ReportData, file: KeptFile) -> Html:
    words = Path(file.path).stem.replace("_", " ")
    caption = tag("figcaption", f"{words[:1].upper()}{words[1:]} (", code(file.path), ")")
    writer = data.digest.writers.get(file.path, "")
    source = f"from {writer}" if writer else "drawn from the rows of this run"
    alt = f"{words} of {data.name}, {source}"
    return _picture(data, file, caption, alt, file.size <= FIGURE_SHOWN)


def _picture(data: ReportData, file: KeptFile, caption: Html, alt: str, fits: bool) -> Html:
    if not fits or file.fault:
        why = file.fault or size(file.size)
        return tag("figure", paragraph(f"{file.path} is not shown here: {why}"), caption)
    told = b64encode((data.folder / file.path).read_bytes()).decode()
    image = Html(f'<img alt="{text(alt)}" src="data:{file.format};base64,{told}">')
    return tag("figure", image, caption)


def data(title: str, data: ReportData) -> Html:
    """The protocol's outputs, and the first rows of each table that the run collected."""
    names = sorted({*data.digest.tables, *_tables(data)})
    return section("data", title, _outputs(data), *(_table(data, name) for name in names))


def _outputs(data: ReportData) -> Html:
    finished = data.digest.finished
    outputs = finished.outputs if finished is not None else {}
    return table("Outputs", ["name", "value"], ((code(n), value(v)) for n, v in outputs.items()))


def _tables(data: ReportData) -> Iterator[str]:
    for file in data.inventory.files:
        own = file.path.startswith("data") or file.path == CHECKS
        if own and file.path.endswith(".csv") and "/" not in file.path:
            yield file.path


def _table(data: ReportData, name: str) -> Html:
    try:
        head, rows = _read_head(data.folder / name)
    except (OSError, UnicodeError, csv.Error) as fault:
        return paragraph(f"{name} cannot be read: {fault}")
    if not head:
        return paragraph(f"{name} is empty.")
    told = data.digest.tables.get(name)
    total = told.count if told is not None else len(rows)
    first = f", the first {len(rows)}" if len(rows) < total else ""
    shown = ([cell[:CELL_SHOWN] for cell in [*row, *[""] * len(head)][: len(head)]] for row in rows)
    if not rows:
        return paragraph(f"{name} has columns ({', '.join(head)}) but no rows.")
    return table(f"{name}: {count(total, 'row')}{first}", head, shown, numbers=_numbers(rows))


def _read_head(path: Path) -> tuple[list[str], list[list[str]]]:
    with path.open(encoding="utf-8", newline="") as file:
        lines = [[bare(cell) for cell in row] for row in islice(csv.reader(file), ROWS_SHOWN + 1)]
    return (lines[0], lines[1:]) if lines else ([], [])


def _numbers(rows: list[list[str]]) -> str:
    width = max(map(len, rows))
    columns = [[row[i] for row in rows if i < len(row) and row[i]] for i in range(width)]
    return "".join("n" if cells and all(map(_is_number, cells)) else "." for cells in columns)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def files(title: str, data: ReportData) -> Html:
    """Every file with size and sha256, checked against the journal; then what is omitted, and why."""
    inventory = data.inventory
    top = [file for file in inventory.files if "/" not in file.path]
    folders: dict[str, list[KeptFile]] = {}
    for file in inventory.files:
        if "/" in file.path:
            folders.setdefault(file.path.rpartition("/")[0], []).append(file)
    missing = (
        (code(file.path), tag("code", file.told, class_="hash")) for file in inventory.missing
    )
    return section(
        "files", title,
        paragraph(_intro(data)),
        _listing("In the run's folder", top, data),
        table("Written by the run, now missing", ["file", "sha256 in the journal"], missing),
        *(_folder(name, held, data) for name, held in folders.items()),
        _left_out(data),
    )  # fmt: skip


def _intro(data: ReportData) -> str:
    inventory = data.inventory
    total = sum(file.size for file in inventory.files)
    known = sum(1 for file in inventory.files if file.told)
    told = f"{count(len(inventory.files), 'file')}, {size(total)}."
    if known:
        wrong = len(inventory.changed) + len(inventory.missing)
        verdict = "all are unchanged" if not wrong else f"{wrong:,} are changed or missing"
        total_known = known + len(inventory.missing)
        told += f" The journal has the sha256 of {total_known:,} delivered by devices: {verdict}."
    return (
        f"{told} The journal itself is a hash chain; {JOURNAL} ends with record "
        f"{data.digest.last_n:,}, hash {data.digest.last_hash or 'none'}."
    )


def _listing(caption: str, held: Iterable[KeptFile], data: ReportData) -> Html:
    rows = ((code(f.path), f"{f.size:,}", _hash(f), _said(f, data)) for f in held)
    return table(caption, ["file", "bytes", "sha256", ""], rows, numbers=".n")


def _hash(file: KeptFile) -> Html:
    if file.fault:
        return tag("span", file.fault, class_="bad")
    return tag("code", file.sha256, class_="hash")


def _said(file: KeptFile, data: ReportData) -> Html:
    if file.changed:
        now = tag("span", "changed since the run wrote it", class_="bad")
        return join([now, ": the journal has ", tag("code", file.told, class_="hash")])
    if file.path in data.stale_tables:
        return tag("span", "does not match the journal's rows", class_="bad")
    writer = data.digest.writers.get(file.path, "")
    return join(["matches the journal; from ", code(writer)]) if file.told and writer else Html()


def _folder(name: str, held: list[KeptFile], data: ReportData) -> Html:
    total = sum(file.size for file in held)
    title = f"{name}/: {count(len(held), 'file')}, {size(total)}"
    listing = _listing(title, held, data)
    bad = any(file.changed or file.fault for file in held)
    openly = len(held) <= LISTED_OPEN or (bad and len(held) <= MANY)
    return listing if openly else folded(title, listing)


def _left_out(data: ReportData) -> Html:
    told = [
        f"Not listed: {PAGE} (this page) and {CRATE}, made from these files; the crate has the page's hash."
    ]
    if data.inventory.working:
        told.append(
            "Not listed, being working state: the engine's lock, and the folder servers/ with the "
            "ledgers, logs and simulated world of the run's own device servers."
        )
    return paragraph(tag("span", " ".join(told), class_="soft"))


def versions(title: str, data: ReportData) -> Html:
    """The software versions of the run and of this report."""
    digest = data.digest
    rows = []
    if digest.started is not None:
        rows.append(("labrun, at the start of the run", digest.started.labrun))
        rows.append(("Python, at the start of the run", digest.started.python))
    rows += [(f"labrun, engine {life.number}", life.labrun) for life in digest.spans.lives[1:]]
    by_path = {file.path: file.sha256 for file in data.inventory.files}
    for what, path in (("protocol", data.inputs.protocol_name), ("lab", "lab.yaml")):
        if path in by_path:
            rows.append(
                (f"sha256 of the {what} ({path})", tag("code", by_path[path], class_="hash"))
            )
    installed = [*data.versions.items(), ("machine", data.machine)]
    return section(
        "versions", title,
        table("Versions of the run", ["what", "version"], rows),
        table(f"Versions of this report, made {data.made_at}", ["what", "version"], installed),
    )  # fmt: skip
