"""A table of standards: what is known of each sample, and which spectra are of it."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path, PurePath

from ..lines.formula import element_in

PER_CENT = {
    "wt %": 1.0, "wt%": 1.0, "wt.%": 1.0, "wt. %": 1.0, "mass %": 1.0, "gew.-%": 1.0, "%": 1.0, "g/kg": 0.1,
    "mg/g": 0.1,
    "ppm": 1e-4, "ug/g": 1e-4, "mg/kg": 1e-4, "ppb": 1e-7, "ug/kg": 1e-7,
}  # fmt: skip
UNITS = "wt %, g/kg, ppm, mg/kg, ppb"
HEADING = re.compile(r"\s*([A-Za-z0-9]+)\s*(?:[(\[_,]?\s*([^)\]]+?)\s*[)\]]?)?\s*")
# As analyses of rocks head it, and what else they have that is no concentration of an element.
TOTAL_IRON = re.compile(r"(FeO|Fe2O3)[ _]?(?:\*|\(?[Tt](?:ot(?:al)?)?\)?)(?![a-z])")
TOTAL = re.compile(r"(?:(?:MOC|oxides?) )?(?:total|sum|loi)(?:\W+(?:wt|mass|gew|%).*)?", re.I)
CELL = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*")
MOST = 100.5  # wt %, of one element and of all
MOST_WRITTEN = 103.0  # of oxides and elements as they are written: a good analysis may total 101


class StandardsFault(ValueError):
    """What is wrong with a table of standards: `problems`, each a sentence with its place."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


@dataclass(frozen=True, slots=True)
class Standard:
    """A sample. wt_percent: by element, of what is known. files: patterns of its spectra's names."""

    sample: str
    wt_percent: dict[str, float]
    files: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Standards:
    """The samples of a table, in its order. notes: sentences on what was converted."""

    samples: tuple[Standard, ...]
    notes: tuple[str, ...]

    @property
    def elements(self) -> list[str]:
        """Elements with a concentration, in the order in which they occur."""
        return list(dict.fromkeys(e for one in self.samples for e in one.wt_percent))


@dataclass(frozen=True, slots=True)
class _Column:
    place: int
    heading: str
    unit: str
    element: str
    factor: float  # wt % of the element, per unit of the column


def read_standards(text: str, name: str) -> Standards:
    """The table in a CSV file's text: `sample`, perhaps `file`, and `Li (ppm)`, `SiO2 (wt %)`, ...

    name: of the file, for messages. An empty cell is unknown. Raises StandardsFault with all
    problems.
    """
    lines = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip(" ,;\t") and line[0] != "#"
    ]  # fmt: skip
    if not lines:
        raise StandardsFault([
            f"{name}: it is empty; it needs headings, as in `sample,Li (ppm)`, and a row for each standard"
        ])  # fmt: skip
    between = max(";\t,", key=lines[0][1].count)
    rows = [(n, next(csv.reader([line], delimiter=between))) for n, line in lines]
    headings = [cell.strip() for cell in rows[0][1]]
    words = [heading.casefold() for heading in headings]
    if "sample" not in words:
        raise StandardsFault([
            f"{name}:{rows[0][0]}: no column `sample`; it has {', '.join(headings)}; call that of the "
            "standards' names `sample`"
        ])  # fmt: skip
    problems: list[str] = []
    columns = _columns(headings, f"{name}:{rows[0][0]}", problems)
    samples = [
        _standard(f"{name}:{n}", cells, words, columns, between != ",", problems)
        for n, cells in rows[1:]
    ]
    first: dict[str, int] = {}
    problems += [
        f"{name}:{n}: {one.sample!r} has a row already, line {first[one.sample.casefold()]}; give one "
        "row to each standard, with all its files"
        for (n, _), one in zip(rows[1:], samples, strict=True)
        if one.sample and first.setdefault(one.sample.casefold(), n) != n
    ]
    if not problems and not any(one.wt_percent for one in samples):
        problems.append(
            f"{name}: no concentration of any element; write what is known of each standard, 0 for none"
        )
    if problems:
        raise StandardsFault(list(dict.fromkeys(problems)))
    notes = [
        f"{c.heading}: wt % of {c.element} are {c.factor:.5g} times it"
        for c in columns if c.factor not in PER_CENT.values()
    ] + [f"{heading}: left aside" for heading in headings if TOTAL.fullmatch(heading)]  # fmt: skip
    return Standards(tuple(samples), tuple(notes))


def _columns(headings: list[str], where: str, problems: list[str]) -> list[_Column]:
    found: list[_Column] = []
    for place, heading in enumerate(headings):
        aside = heading.casefold() in ("sample", "file", "note", "notes", "")
        if aside or TOTAL.fullmatch(heading):
            continue
        told = HEADING.fullmatch(TOTAL_IRON.sub(r"\1", heading))
        formula, unit = told.groups() if told else (heading, "")
        try:
            element, part = element_in(formula)
        except ValueError as fault:
            problems.append(f"{where}: column {heading!r}: {fault}; call a remark `note`")
            continue
        if _plain(unit) not in PER_CENT:
            what = f"the unit {unit!r} is not known" if unit else "it has no unit"
            problems.append(
                f"{where}: column {heading!r}: {what}; write one of {UNITS}, as in `{formula} (ppm)`"
            )
        elif any(element == one.element for one in found):
            problems.append(f"{where}: column {heading!r}: {element} has a column already")
        else:
            factor = PER_CENT[_plain(unit)] * part
            found.append(_Column(place, heading, _plain(unit), element, factor))
    return found


def _plain(unit: str | None) -> str:
    return (unit or "").strip().replace("µ", "u").replace("μ", "u").casefold()


def _standard(
    where: str, cells: list[str], words: list[str], columns: list[_Column],
    decimal_comma: bool, problems: list[str],
) -> Standard:  # fmt: skip
    if any(cell.strip() for cell in cells[len(words) :]):
        problems.append(
            f"{where}: it has {len(cells)} cells, where the headings are {len(words)}; are there decimal "
            "commas? Then put semicolons between the columns"
        )
    cells = [*cells, *[""] * (len(words) - len(cells))]
    sample = cells[words.index("sample")].strip()
    files = cells[words.index("file")].split("|") if "file" in words else []
    if not sample:
        problems.append(f"{where}: the sample has no name")
    known: dict[str, float] = {}
    written = 0.0
    for column in columns:
        cell = cells[column.place].strip()
        if not cell or cell in ("-", "–"):
            continue
        told = CELL.fullmatch(cell.replace(",", ".") if decimal_comma else cell)
        if cell[0] in "<>~≈":
            problems.append(
                f"{where}: {column.heading}: {cell!r} is no concentration; leave it empty, or write 0 "
                "if there is none"
            )
        elif told is None or not _number(told[1]) or not _unit_or_comma(told[2]):
            problems.append(
                f"{where}: {column.heading}: {cell!r} is not a number; leave it empty where it is unknown"
            )
        elif told[2].startswith(","):
            problems.append(
                f"{where}: {column.heading}: {cell!r} has a comma; write a point, or put semicolons "
                "between the columns"
            )
        elif told[2] and PER_CENT[_plain(told[2])] != PER_CENT[column.unit]:
            problems.append(
                f"{where}: {column.heading}: {cell!r} is in another unit than its column ({column.unit}); "
                "convert it"
            )
        elif float(told[1]) < 0:
            problems.append(
                f"{where}: {column.heading}: {cell!r} is below 0, which no concentration is; write 0 if "
                "there is none"
            )
        elif not float(told[1]) * column.factor <= MOST:
            problems.append(
                f"{where}: {column.heading}: {cell} {column.unit} cannot be; is it in another unit?"
            )
        else:
            known[column.element] = float(told[1]) * column.factor
            written += float(told[1]) * PER_CENT[column.unit]
    if sum(known.values()) > MOST:
        problems.append(
            f"{where}: the elements of {sample} are {sum(known.values()):.1f} wt % together; are units mixed?"
        )
    elif written > MOST_WRITTEN:
        problems.append(
            f"{where}: what is written of {sample} is {written:.1f} wt % together; are units mixed, or "
            "elements written as oxides?"
        )
    return Standard(sample, known, tuple(one.strip() for one in files if one.strip()))


def _unit_or_comma(text: str) -> bool:
    """Of what follows a number: nothing, a known unit, or a comma, which has a word of its own."""
    return not text or text.startswith(",") or _plain(text) in PER_CENT


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def spectra_of(standards: Standards, paths: Sequence[Path], name: str) -> dict[str, list[Path]]:
    """The spectra of each sample: by its patterns, else by names that begin with the sample's.

    Raises StandardsFault for spectra of no sample, or of two; samples without spectra have none.
    """
    found: dict[str, list[Path]] = {one.sample: [] for one in standards.samples}
    problems: list[str] = []
    nobodys: list[Path] = []
    for path in paths:
        named = [one for one in standards.samples if any(_fits(path, f) for f in one.files)]
        named = named or [
            one for one in standards.samples if not one.files and _begins(path.name, one.sample)
        ]
        if len(named) > 1 and not named[0].files:
            named = [max(named, key=lambda one: len(one.sample))]
        if not named:
            nobodys.append(path)
        elif len(named) > 1:
            both = " and ".join(one.sample for one in named[:2])
            problems.append(f"{path}: {both} of {name} both claim this spectrum")
        else:
            found[named[0].sample].append(path)
    if nobodys:
        more = f" (and of {len(nobodys) - 1} more)" if len(nobodys) > 1 else ""
        problems.append(
            f"{nobodys[0]}: no row of {name} is of this spectrum{more}; begin its name with the "
            "sample's, write it in the column `file` (names or patterns, with | between), or leave it out"
        )
    if problems:
        raise StandardsFault(problems)
    return found


def _fits(path: Path, pattern: str) -> bool:
    return fnmatch(path.name, pattern) or path.as_posix().endswith("/" + pattern) or (
        PurePath(path).stem == pattern
    )  # fmt: skip


def _begins(name: str, sample: str) -> bool:
    rest = name[len(sample) :]
    return name.casefold().startswith(sample.casefold()) and not rest[:1].isalnum()
