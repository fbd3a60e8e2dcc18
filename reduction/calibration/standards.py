"""A table of standards: what is known of each sample, and which spectra are of it."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path, PurePath

from ..lines.formula import element_in
from ..spectrum.rows_of_shots import PYHAT

PER_CENT = {
    "%": 1.0, "wt%": 1.0, "weight%": 1.0, "mass%": 1.0, "gew%": 1.0, "m%": 1.0, "%m/m": 1.0, "%w/w": 1.0,
    "w/w%": 1.0, "percent": 1.0, "g/100g": 1.0, "g/kg": 0.1, "mg/g": 0.1,
    "ppm": 1e-4, "ug/g": 1e-4, "mg/kg": 1e-4, "ppb": 1e-7, "ug/kg": 1e-7, "ng/g": 1e-7,
}  # fmt: skip
TYPESET = str.maketrans("µμ−⁻¹₀₁₂₃₄₅₆₇₈₉", "uu--10123456789")
PER_GRAM = re.compile(r"([umn]?g)(k?g)-1")  # ug g-1
UNITS = "wt %, g/kg, ppm, mg/kg, ppb"
HEADING = re.compile(r"\s*([A-Za-z0-9]+)\s*(?:[(\[_,]?\s*([^)\]]+?)\s*[)\]]?)?\s*")
# As analyses of rocks head it, and what else they have that is no concentration of an element.
TOTAL_IRON = re.compile(r"(FeO|Fe2O3)[ _]?(?:\*|\(?[Tt](?:ot(?:al)?)?\)?)(?![a-z])")
TOTAL = re.compile(
    r"%? ?(?:(?:MOC|oxides?) )?(?:total|sum|loi|h2o ?[-+−])(?:\W+(?:wt|mass|gew|%).*)?", re.I
)
ERROR = re.compile(
    r".*(?:±|\+/-|(?<![a-z])(?:err(?:or)?|std(?:ev)?|s\.?d\.?|rsd|sigma|uncert[a-z]*|u\(.*\))(?![a-z])).*",
    re.I,
)
BLANKS = str.maketrans("-_", "  ")  # in names of files, which often lose them
UNIT_ROW = ("", "unit", "units")
UNKNOWN = ("", "-", "–", "—", "−", "nan", "na", "n/a", "#n/a")
NONE_SEEN = re.compile(r"[<>~≈].*|n\.? ?d\.?|b\.?d\.?l\.?|lod|trace|tr\.?|none", re.I)
GROUPED = re.compile(r"[-+]?\d{1,3}(?:\.\d{3})+")
CELL = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*")
SHOWN = 8  # headings in a message
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
    """The samples of a table, in its order. notes: sentences on what was converted.

    rows: the sample of each row, where a row has its spectrum, too; else empty.
    """

    samples: tuple[Standard, ...]
    notes: tuple[str, ...]
    rows: tuple[str, ...] = ()

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

    A column for each standard in place of a row, units in a line of their own, and PyHAT's tables
    (`meta`, `comp` and `wvl` above the headings) are read, too. name: of the file, for messages. An
    empty cell is unknown. Raises StandardsFault with all problems.
    """
    lines = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip(" ,;\t") and line[0] != "#"
    ]  # fmt: skip
    if not lines:
        raise StandardsFault([
            f"{name}: it is empty; it needs headings, as in `sample,Li (ppm)`, and a row for each standard"
        ])  # fmt: skip
    between = max(";\t,", key=lines[0][1].count)
    rows = [
        (f"{name}:{n}", [cell.strip() for cell in next(csv.reader([line], delimiter=between))])
        for n, line in lines
    ]
    notes: list[str] = []
    rows, has_spectra = _without_spectra(rows, notes)
    rows = _upright(rows, name, notes)
    headings = rows[0][1]
    words = [heading.casefold() for heading in headings]
    if "sample" not in words:
        shown = ", ".join(headings[:SHOWN]) + (" ..." if len(headings) > SHOWN else "")
        raise StandardsFault([
            f"{rows[0][0]}: no column `sample`; it has {shown}; call that of the standards' names `sample`"
        ])  # fmt: skip
    rows = _with_units(rows, words.index("sample"))
    problems: list[str] = []
    if between != ",":
        problems += _two_readings(rows)
    columns = _columns(rows, problems, notes)
    samples = [
        _standard(where, cells, words, columns, between != ",", problems)
        for where, cells in rows[1:]
    ]
    named = tuple(one.sample for one in samples)
    first: dict[str, tuple[str, Standard]] = {}
    for (where, _), one in zip(rows[1:], samples, strict=True):
        before, same = first.setdefault(one.sample.casefold(), (where, one))
        if not one.sample or before == where or (has_spectra and same == one):
            continue
        problems.append(
            f"{where}: {one.sample!r} has a row already, {_place(before, name)}; give one row to each "
            "standard, with all its files"
            if not has_spectra
            else f"{where}: {one.sample!r} has another composition than {_place(before, name)}"
        )
    samples = [one for _, one in first.values()] if has_spectra else samples
    if not problems and not any(one.wt_percent for one in samples):
        problems.append(
            f"{name}: no concentration of any element; write what is known of each standard, 0 for none"
        )
    if problems:
        raise StandardsFault(list(dict.fromkeys(problems)))
    notes += [
        f"{c.heading}: wt % of {c.element} are {c.factor:.5g} times it"
        for c in columns if c.factor not in PER_CENT.values()
    ]  # fmt: skip
    return Standards(tuple(samples), tuple(notes), named if has_spectra else ())


_Rows = list[tuple[str, list[str]]]  # each with its place


def _place(where: str, name: str) -> str:
    return where.removeprefix(name).lstrip(", ").replace(":", "line ")


def _without_spectra(rows: _Rows, notes: list[str]) -> tuple[_Rows, bool]:
    """PyHAT's table without its wavelengths; and whether it had any."""
    kinds = [kind.casefold() for kind in rows[0][1]]
    if len(rows) < 3 or "comp" not in kinds or not PYHAT.issuperset(kinds):
        return rows, False
    kept = [k for k, kind in enumerate(kinds) if kind in ("meta", "comp")]
    rows = [(where, [cells[k] for k in kept if k < len(cells)]) for where, cells in rows[1:]]
    where, headings = rows[0]
    metas = [k for k, at in enumerate(kept) if kinds[at] == "meta"]
    named = next((k for k in metas if headings[k].casefold() == "sample"), (*metas, 0)[0])
    if headings[named].casefold() != "sample":
        notes.append(f"the standards' names are those of {headings[named]!r}")
    wanted = [named, *(k for k in range(len(headings)) if k not in metas)]
    rows = [(where, [cells[k] for k in wanted if k < len(cells)]) for where, cells in rows]
    rows = _usable(rows, notes)
    comps = rows[0][1][1:]
    oxides = [heading for heading in comps if _of_element(heading) and _formula(heading)[1] == ""]
    oxides = [heading for heading in oxides if element_in(_formula(heading)[0])[1] < 1]
    if oxides:
        notes.append(f"{', '.join(oxides)}: read as wt %, as no unit is said")
    rows[0] = where, ["sample", *(f"{one} (wt %)" if one in oxides else one for one in comps)]
    return rows, "wvl" in kinds


def _usable(rows: _Rows, notes: list[str]) -> _Rows:
    """Of a table that another program reads, too, and so is not to be changed for this one: columns that
    are amounts of an element, one of each, and no amounts below 0."""
    headings = rows[0][1]
    found: dict[int, tuple[str, tuple[bool, float]]] = {}
    for k, heading in enumerate(headings[1:], 1):
        formula, unit = _formula(heading)
        part = PER_CENT.get(_plain(unit or "%"))
        if part is not None and _of_element(heading):
            found[k] = element_in(formula)[0], (not TOTAL_IRON.match(heading), part)
    kept = [0]
    for k, (element, rank) in found.items():
        ranks = [other for one, other in found.values() if one == element]
        # Total iron, or the finer unit; FeO beside Fe2O3 is no choice of ours.
        if rank == min(ranks) or ranks.count(min(ranks)) > 1:
            kept.append(k)
    if aside := [heading for k, heading in enumerate(headings) if k not in kept]:
        notes.append(f"{', '.join(aside)}: left aside")
    rows = [(where, [cells[k] for k in kept if k < len(cells)]) for where, cells in rows]
    below = 0
    for _, cells in rows[1:]:
        for k in range(1, len(cells)):
            if _number(cells[k]) and float(cells[k]) < 0:
                cells[k], below = "", below + 1
    if below:
        notes.append(
            f"amounts below 0, as a background leaves them, are taken as unknown: {below} of them"
        )
    return rows


def _upright(rows: _Rows, name: str, notes: list[str]) -> _Rows:
    """A row for each standard, also where each has a column."""
    headings = rows[0][1]
    below = [cells[0] for _, cells in rows[1:]]
    if any(map(_of_element, headings)) or 2 * sum(map(_of_element, below)) <= len(below):
        return rows
    wide = max(len(cells) for _, cells in rows)
    turned = zip(*(cells + [""] * (wide - len(cells)) for _, cells in rows), strict=True)
    found = [(f"{name}, column {k}", list(cells)) for k, cells in enumerate(turned, 1)]
    found[0][1][0] = "sample"
    notes.append("a column is a standard")
    aside = [cells[0] for _, cells in found[1:] if ERROR.fullmatch(cells[0])]
    if aside:
        notes.append(f"{', '.join(aside)}: left aside, as errors of certificates")
    return [one for one in found if any(one[1]) and not ERROR.fullmatch(one[1][0])]


def _of_element(heading: str) -> bool:
    try:
        element_in(_formula(heading)[0])
    except ValueError:
        return False
    return True


def _with_units(rows: _Rows, name_at: int) -> _Rows:
    """Units that stand in a line of their own, put into the headings."""
    if len(rows) < 2:
        return rows
    where, headings = rows[0]
    units = rows[1][1]
    rest = [unit for k, unit in enumerate(units) if k != name_at and unit]
    named = units[name_at].casefold() if name_at < len(units) else ""
    if named not in UNIT_ROW or not rest or any(_plain(unit) not in PER_CENT for unit in rest):
        return rows
    units = units + [""] * (len(headings) - len(units))
    joined = [
        f"{heading} ({unit})" if unit and k != name_at else heading
        for k, (heading, unit) in enumerate(zip(headings, units, strict=False))
    ]
    return [(where, joined), *rows[2:]]


def _two_readings(rows: _Rows) -> list[str]:
    """Problems of 277.000 beside 59,3: it may be either."""
    if not any(re.fullmatch(r"[-+]?\d+,\d+", cell) for _, cells in rows[1:] for cell in cells):
        return []
    return [
        f"{where}: {cell!r} may be {cell.replace('.', '')} or {float(cell):g}, since others have decimal "
        "commas; write it without the point"
        for where, cells in rows[1:]
        for cell in cells
        if GROUPED.fullmatch(cell) and cell.count(".") == 1
    ]


def _formula(heading: str) -> tuple[str, str]:
    """The formula and the unit in a heading."""
    told = HEADING.fullmatch(TOTAL_IRON.sub(r"\1", heading.translate(TYPESET)))
    return (told[1], told[2] or "") if told else (heading, "")


def _columns(rows: _Rows, problems: list[str], notes: list[str]) -> list[_Column]:
    found: list[_Column] = []
    where, headings = rows[0]
    for place, heading in enumerate(headings):
        if heading.casefold() in ("sample", "file", "note", "notes", ""):
            continue
        if TOTAL.fullmatch(heading):
            notes.append(f"{heading}: left aside")
            continue
        if ERROR.fullmatch(heading):
            notes.append(f"{heading}: left aside, as an error of the certificates")
            continue
        formula, unit = _formula(heading)
        try:
            element, part = element_in(formula)
        except ValueError as fault:
            cells = [cells[place] for _, cells in rows[1:] if place < len(cells)]
            if any(map(CELL.fullmatch, cells)):
                problems.append(f"{where}: column {heading!r}: {fault}; call a remark `note`")
            else:
                notes.append(f"{heading}: left aside, as words")
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
            found.append(_Column(place, heading, unit, element, factor))
    return found


def _plain(unit: str) -> str:
    bare = re.sub(r"[\s.]", "", unit.translate(TYPESET)).casefold().replace("-%", "%")
    return PER_GRAM.sub(r"\1/\2", bare)


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
        if cell.casefold() in UNKNOWN:
            continue
        told = CELL.fullmatch(cell.replace(",", ".") if decimal_comma else cell)
        if NONE_SEEN.fullmatch(cell):
            problems.append(
                f"{where}: {column.heading}: {cell!r} is no concentration; leave it empty, or write 0 "
                "if there is none"
            )
        elif "±" in cell or "+/-" in cell:
            problems.append(
                f"{where}: {column.heading}: {cell!r}: write the value alone; a certificate's error is not "
                "counted"
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
        elif told[2] and PER_CENT[_plain(told[2])] != PER_CENT[_plain(column.unit)]:
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
            written += float(told[1]) * PER_CENT[_plain(column.unit)]
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
        for blanks in ({}, BLANKS):  # as they are written, then any for any
            named = named or [
                one
                for one in standards.samples
                if not one.files and _begins(path.name, one.sample, blanks)
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


def _begins(name: str, sample: str, blanks: dict[int, int]) -> bool:
    rest = name[len(sample) :]
    begins = name.casefold().translate(blanks).startswith(sample.casefold().translate(blanks))
    return begins and not rest[:1].isalnum()
