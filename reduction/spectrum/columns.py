"""Choose the columns of a table: the one with wavelengths, and those with a shot each."""

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .axis import Unit, counts_channels, in_nm, may_be_nm, unit_named
from .fault import Unreadable
from .spectrum import FloatArray

AXIS = re.compile(
    r"wave|lambda|λ|^w\.?v?l(\b|_)|^nm\b|\[nm\]|\(nm\)|^x\b|^w$|[åÅ]ngstr|^axis", re.I
)
COUNTER = re.compile(
    r"pixel|channel|^(index|idx|no|nr|row|px|ch|#)\b\.?|^(col(umn)?|frame|roi|region|strip)$|order",
    re.I,
)
BESIDE = re.compile(
    r"dark|backg|\bbg\b|\bref|white|err|std|stdev|sigma|\bsd\b|unc|noise|±|%|transm|reflec|absor"
    r"|irradi|temperat|time|^expos|start|ended|normal|smooth|filtered|base|^energy|^freq|^[dr]$|flag|mask|satur|weight|\bfit\b|valid|dunkel|grund|fehler|rausch"
    r"|obscur|fondo|\bbruit|тёмн|темн|фон|шум|暗|背景|参考|参比|噪声|误差|ダーク", re.I
)  # fmt: skip
RESULT = re.compile(
    r"^(sum|total|scope)$|correct|process|subtract|\bnet\b|^p$|minus|mean|average|\bavg\b", re.I
)
# Not the light of a plasma, in counts or in proportion to them.
NO_LIGHT = re.compile(
    r"absorban|absorpt|transmi|reflec|extinct|kubelka|^%\s?[RT]$|^[RT]\s?%$|\bOD\b|\bdB\b|\blog(10|e|arithm)?(?![a-z])",
    re.I,
)
# A line above the table that says it of all: "Mode: Reflectance", or one word over two columns.
NO_LIGHT_SAID = re.compile(
    r"([^:=,;\t]*[:=,;\t])?[^\w:=,;\t]*((total|diffuse|specular|relative|percent)\s+)?"
    r"(reflectance|reflectivity|transmittance|absorbance|extinction)[^\w:=,;\t]*",
    re.I,
)
UNLIKE = 5.0  # ratio of the median counts of columns that cannot be shots of one another
LEAST_ALIKE = 0.3  # correlation of shots
FEW_CHANGES = 0.01  # of the rows, where labels change
LEAST_LABELLED = 50  # rows
MOST_SHARED = 0.5  # of the range, that ranges of one instrument may overlap
HOW = "say which with --columns, as in --columns 1,2 (wavelengths, counts) or by their headings"
SHOT = re.compile(r"shot|spectr|scan|burst|pulse|acqui|measure|frame|replicate|\d$", re.I)
SHOWN = 8


@dataclass(frozen=True, slots=True)
class Chosen:
    """Indices from 0. unit: None where no heading says it."""

    axis: int
    shots: tuple[int, ...]
    unit: Unit | None
    notes: tuple[str, ...]


def choose(headings: Sequence[str], table: FloatArray, asked: Sequence[str] | None) -> Chosen:
    """headings: () without any. table: shape (columns, n); a column of words is all NaN.

    Raises Unreadable where it would be a guess.
    """
    names = list(headings) or [""] * len(table)
    if asked is not None:
        axis, *shots = (_index(one, names) for one in asked)
        return Chosen(axis, tuple(shots), _unit(names[axis]), ())
    axis, notes = _axis(names, table)
    words = [at for at in range(len(table)) if at != axis and np.isnan(table[at]).all()]
    words += [at for at in _axes_said(names) if at != axis]
    shots = [at for at in range(len(table)) if at != axis and at not in words]
    if len(shots) > 1:
        shots = [at for at in shots if not _labels(table[at])] or shots
    shots = [at for at in shots if not COUNTER.search(names[at])] or shots
    if headings:
        shots = _by_name(names, shots)
    shots = [at for at in shots if not _counts_from_start(table[at])] or shots
    if shots and all(NO_LIGHT.search(names[at]) for at in shots):
        raise Unreadable(
            f"{_called(names, shots[0])} has no counts of light that a plasma emits; export these, or {HOW}"
        )
    if len(shots) > 1 and not all(names[at] for at in shots):
        _check_alike(table, shots)
        notes.append(
            f"{len(shots)} columns without headings are read as shots (if they are none, {HOW})"
        )
    aside = [_called(names, at) for at in range(len(table)) if at != axis and at not in shots]
    if len(shots) > 1 and any(names[at] for at in shots):
        unsure = (
            "" if all(SHOT.search(names[at]) for at in shots) else f" (if they are none, {HOW})"
        )
        notes.append(f"read as shots: {_listed([_called(names, at) for at in shots])}{unsure}")
    if aside:
        notes.append(f"not used: {_listed(aside)}")
    return Chosen(axis, tuple(shots), _unit(names[axis]), tuple(notes))


def check_light(quantity: str, what: str) -> None:
    """Raise Unreadable for the quantity of a file's only spectrum that is no light of a plasma."""
    if NO_LIGHT.search(quantity):
        raise Unreadable(
            f"{what} with {quantity.strip()[:40]!r}, and no counts of light that a plasma emits; "
            "export these"
        )


def check_above(lines: Sequence[str]) -> None:
    """Raise Unreadable where a line above the table says that it has no light of a plasma."""
    for line in lines:
        if NO_LIGHT_SAID.fullmatch(line):
            raise Unreadable(
                f"above its numbers stands {line.strip()[:40]!r}: these are no counts of light that a "
                f"plasma emits; export these, or {HOW}"
            )


def side_by_side(
    headings: Sequence[str], table: FloatArray
) -> tuple[Sequence[str], FloatArray, list[str]]:
    """Wavelengths and counts, and again wavelengths and counts: as one table with one axis.

    Ranges of one instrument are put one below the other; equal axes are kept once. headings,
    table: as `choose` takes them, and returned as they are where there is one axis. Raises
    Unreadable where it would be a guess.
    """
    names = list(headings) or [""] * len(table)
    axes = _axes_said(names) or _axes_unsaid(table)
    if len(axes) < 2:
        return headings, table, []
    each = {after - at for at, after in itertools.pairwise([*axes, len(table)])}
    if len(each) > 1 or each == {1}:
        return headings, table, []
    (n,) = each
    first = table[axes[0]]
    if all(np.array_equal(table[at], first, equal_nan=True) for at in axes):
        kept = [axes[0], *(at + k for at in axes for k in range(1, n))]
        same = f"column {axes[0] + 1} stands {len(axes)} times"
        return [names[at] for at in kept] if headings else (), table[kept], [same]
    good = [np.isfinite(table[at]) for at in axes]
    if not all(ok.any() for ok in good):
        return headings, table, []
    edges = sorted(
        (table[at][ok].min(), table[at][ok].max()) for at, ok in zip(axes, good, strict=True)
    )
    shared = sum(max(before[1] - after[0], 0.0) for before, after in itertools.pairwise(edges))
    if shared > MOST_SHARED * (edges[-1][1] - edges[0][0]):
        raise Unreadable(
            f"columns {', '.join(str(at + 1) for at in axes)} have wavelengths of the same range, "
            f"and each its own; {HOW}"
        )
    below = np.stack([
        np.concatenate([table[at + k][ok] for at, ok in zip(axes, good, strict=True)])
        for k in range(n)
    ])  # fmt: skip
    note = f"{len(axes)} ranges stand side by side, each with its wavelengths"
    return names[axes[0] : axes[0] + n] if headings else (), below, [note]


def _axes_said(names: list[str]) -> list[int]:
    return [at for at, name in enumerate(names) if AXIS.search(name) and not COUNTER.search(name)]


def _axes_unsaid(table: FloatArray) -> list[int]:
    """Every other column, if these and no others ascend as wavelengths do."""
    ascends = [bool(len(ok := one[np.isfinite(one)]) > 3 and may_be_nm(ok)) for one in table]
    pairs = len(table) >= 4 and ascends == [at % 2 == 0 for at in range(len(table))]
    return list(range(0, len(table), 2)) if pairs else []


def _labels(values: FloatArray) -> bool:
    """Whether these number frames, regions or strips, are flags or one value: no detector's counts."""
    good = values[np.isfinite(values)]
    if len(good) >= LEAST_LABELLED and np.isin(good, (0, 1)).all():
        return True
    if len(good) < LEAST_LABELLED or not np.all(good == np.round(good)):
        return bool(len(good) > LEAST_LABELLED and good.min() == good.max() != 0)
    return int(np.count_nonzero(np.diff(good))) < FEW_CHANGES * len(good)


def _axis(names: list[str], table: FloatArray) -> tuple[int, list[str]]:
    said = _axes_said(names)
    if said:
        return said[0], []
    able = [at for at in range(len(table)) if _axis_like(table[at])]
    if COUNTER.search(names[0]) or not able or able[0] != 0:
        if able and (able[0] != 0 or len(able) > 1):
            at = next(one for one in able if one != 0)
            return at, [f"the wavelengths are {_called(names, at)}"]
        if COUNTER.search(names[0]):
            raise Unreadable(
                f"the first column is headed {names[0]!r}, and no column has wavelengths; "
                f"export the spectrum with its wavelength axis, or {HOW}"
            )
        return 0, []
    if counts_channels(table[0]) and len(able) > 1:
        return able[1], [f"the wavelengths are {_called(names, able[1])}"]
    if able in ([], [0]) and len(table) > 2 and _counts_from_start(table[0]):
        in_nm(table[0])  # says that these are channels
    for name in names[:1]:
        unit_named(name)
    return 0, []


def _axis_like(values: FloatArray) -> bool:
    if len(values) < 3 or not np.isfinite(values).all():
        return False
    ascending = values if values[-1] > values[0] else values[::-1]
    if may_be_nm(ascending):
        return True
    # angstrom and micrometres, detectors that overlap, orders of an echelle
    steps = np.diff(ascending)
    return bool(np.mean(steps > 0) > 0.98 and ascending[0] > 0 and ascending[-1] < 30_000)


def _counts_from_start(values: FloatArray) -> bool:
    return len(values) > 3 and values[0] in (0, 1) and counts_channels(values)


def _by_name(names: list[str], shots: list[int]) -> list[int]:
    plain = [at for at in shots if not BESIDE.search(names[at])]
    results = [at for at in shots if RESULT.search(names[at])]
    results = [at for at in results if not re.search(r"err|std|dev|%", names[at], re.I)]
    if len(results) == 1:
        return results
    return plain or shots


def _check_alike(table: FloatArray, shots: list[int]) -> None:
    """Raise Unreadable where columns without names cannot be shots of one spectrum."""
    first = np.nan_to_num(table[shots[0]])
    for at in shots[1:]:
        other = np.nan_to_num(table[at])
        sizes = sorted((float(np.abs(first).mean()), float(np.abs(other).mean())))
        if not first.std() or not other.std() or len(first) < 10:
            alike = bool(sizes[1] == 0) or len(first) < 10
        else:
            alike = float(np.corrcoef(first, other)[0, 1]) > LEAST_ALIKE
        if not alike or sizes[1] > UNLIKE * sizes[0]:
            raise Unreadable(
                f"columns {shots[0] + 1} and {at + 1} have no headings, and are too unlike to be "
                f"shots of one spectrum; {HOW}"
            )


def _index(one: str, names: list[str]) -> int:
    if one.isdecimal():
        if not 1 <= int(one) <= len(names):
            raise Unreadable(f"--columns: there is no column {one}; the table has {len(names)}")
        return int(one) - 1
    found = [at for at, name in enumerate(names) if name.lower() == one.lower()]
    found = found or [at for at, name in enumerate(names) if name.lower().startswith(one.lower())]
    if len(found) != 1:
        there = _listed([name for name in names if name]) if any(names) else "it has no headings"
        raise Unreadable(f"--columns: {len(found) or 'no'} columns are headed {one!r}; {there}")
    return found[0]


def _unit(name: str) -> Unit | None:
    return unit_named(name)


def _called(names: list[str], at: int) -> str:
    return f"column {at + 1}" + (f" ({names[at]})" if names[at] else "")


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
