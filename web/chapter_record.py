"""Chapters of the report on what the run left: figures, tables, every file, and the versions."""

import csv
from base64 import b64encode
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from ..engine.run_folder import JOURNAL
from .files import CRATE, PAGE, KeptFile
from .markup import Markup, code, folded, join, paragraph, section, table, tag, text
from .material import Material
from .words import count, size

ROWS_SHOWN = 12
CELL_SHOWN = 200
FIGURE_SHOWN = 4_000_000
LISTED_OPEN = 8
"""Files of a folder of the run that are listed openly; a larger folder is folded."""
MANY = 200
"""Files up to which a folder is listed openly where one of them is not as the run wrote it."""


def figures(title: str, material: Material) -> Markup:
    """The pictures, inside the page."""
    return section("figures", title, *(_figure(material, file) for file in material.figures))


def _figure(material: Material, file: KeptFile) -> Markup:
    words = Path(file.path).stem.replace("_", " ")
    caption = tag("figcaption", f"{words[:1].upper()}{words[1:]} (", code(file.path), ")")
    if file.size > FIGURE_SHOWN or file.fault:
        return tag(
            "figure", paragraph(f"{file.path} is left out here: {file.fault or size(file.size)}")
        )
    told = b64encode((material.folder / file.path).read_bytes()).decode()
    alt = f"{words} of {material.name}, drawn from the rows of this run"
    image = Markup(f'<img alt="{text(alt)}" src="data:{file.format};base64,{told}">')
    return tag("figure", image, caption)


def data(title: str, material: Material) -> Markup:
    """The head of each table that the run collected."""
    names = sorted({*material.story.tables, *_tables(material)})
    return section("data", title, *(_table(material, name) for name in names))


def _tables(material: Material) -> Iterator[str]:
    for file in material.inventory.files:
        if file.path.startswith("data") and file.path.endswith(".csv") and "/" not in file.path:
            yield file.path


def _table(material: Material, name: str) -> Markup:
    try:
        head, rows = _read_head(material.folder / name)
    except (OSError, UnicodeError, csv.Error) as fault:
        return paragraph(f"{name} cannot be read: {fault}")
    if not head:
        return paragraph(f"{name} is empty.")
    told = material.story.tables.get(name)
    total = told.count if told is not None else len(rows)
    first = f", the first {len(rows)}" if len(rows) < total else ""
    shown = ([cell[:CELL_SHOWN] for cell in [*row, *[""] * len(head)][: len(head)]] for row in rows)
    if not rows:
        return paragraph(f"{name} has columns ({', '.join(head)}) and no row.")
    return table(f"{name}: {count(total, 'row')}{first}", head, shown, numbers=_numbers(rows))


def _read_head(path: Path) -> tuple[list[str], list[list[str]]]:
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(islice(csv.reader(file), ROWS_SHOWN + 1))
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


def files(title: str, material: Material) -> Markup:
    """Every file with size and sha256, held against the journal; then what is left out, and why."""
    inventory = material.inventory
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
        paragraph(_intro(material)),
        _listing("In the run's folder", top, material),
        table("Written by the run, and gone now", ["file", "sha256 in the journal"], missing),
        *(_folder(name, held, material) for name, held in folders.items()),
        _left_out(material),
    )  # fmt: skip


def _intro(material: Material) -> str:
    inventory = material.inventory
    total = sum(file.size for file in inventory.files)
    known = sum(1 for file in inventory.files if file.told)
    told = f"{count(len(inventory.files), 'file')}, {size(total)}."
    if known:
        wrong = len(inventory.changed) + len(inventory.missing)
        verdict = (
            "all of them are as the run wrote them"
            if not wrong
            else f"{wrong:,} are not what the run wrote, or gone"
        )
        total_known = known + len(inventory.missing)
        told += f" The journal has the sha256 of {total_known:,} that devices delivered: {verdict}."
    return (
        f"{told} The journal itself is a chain of hashes; {JOURNAL} ends with record "
        f"{material.story.records:,}, hash {material.story.last_hash or 'none'}."
    )


def _listing(caption: str, held: Iterable[KeptFile], material: Material) -> Markup:
    rows = ((code(f.path), f"{f.size:,}", _hash(f), _said(f, material)) for f in held)
    return table(caption, ["file", "bytes", "sha256", ""], rows, numbers=".n")


def _hash(file: KeptFile) -> Markup:
    if file.fault:
        return tag("span", file.fault, class_="bad")
    return tag("code", file.sha256, class_="hash")


def _said(file: KeptFile, material: Material) -> Markup:
    if file.changed:
        now = tag("span", "changed since the run wrote it", class_="bad")
        return join([now, ": the journal has ", tag("code", file.told, class_="hash")])
    if file.path in material.stale_tables:
        return tag("span", "does not hold the journal's rows", class_="bad")
    writer = material.story.writers.get(file.path, "")
    return join(["as in the journal, by ", code(writer)]) if file.told and writer else Markup()


def _folder(name: str, held: list[KeptFile], material: Material) -> Markup:
    total = sum(file.size for file in held)
    title = f"{name}/: {count(len(held), 'file')}, {size(total)}"
    listing = _listing(title, held, material)
    bad = any(file.changed or file.fault for file in held)
    openly = len(held) <= LISTED_OPEN or (bad and len(held) <= MANY)
    return listing if openly else folded(title, listing)


def _left_out(material: Material) -> Markup:
    told = [
        f"{PAGE} (this page) and {CRATE} are made from the list above; the crate has this page's hash."
    ]
    if material.inventory.working:
        told.append(
            "Left out as working state: the engine's lock, and the folder servers/ with the ledgers, "
            "logs and simulated world of the run's own device servers."
        )
    return paragraph(tag("span", " ".join(told), class_="soft"))


def versions(title: str, material: Material) -> Markup:
    """What made the run, and what made this report."""
    story = material.story
    rows = []
    if story.started is not None:
        rows.append(("labrun, when the run began", story.started.labrun))
        rows.append(("Python, when the run began", story.started.python))
    rows += [(f"labrun, engine {life.number}", life.labrun) for life in story.spans.lives[1:]]
    by_path = {file.path: file.sha256 for file in material.inventory.files}
    for what, path in (("protocol", material.inputs.protocol_name), ("lab", "lab.yaml")):
        if path in by_path:
            rows.append(
                (f"sha256 of the {what} ({path})", tag("code", by_path[path], class_="hash"))
            )
    installed = [*material.versions.items(), ("machine", material.machine)]
    return section(
        "versions", title,
        table("What the run was made by", ["what", "version"], rows),
        table(f"What this report was made with, {material.made_at}", ["what", "version"], installed),
    )  # fmt: skip
