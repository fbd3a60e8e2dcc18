"""What `labrun calibrate standards` does: shots of standards in, curves and their file out."""

import getpass
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

from ...system.extras import missing
from .reducing import say_skipped, unread
from .say import say
from .words import closure as _closure
from .words import known_response, own_lines, sha256_of


@dataclass(frozen=True, slots=True)
class Asked:
    """The command line."""

    standards: Path
    files: list[Path]
    normalise: str | None
    lines_nm: list[str]
    curve: str | None
    model: str | None
    closure: str | None
    lines: Path | None
    response: Path | None
    by: str | None
    note: str
    output: Path
    figures: bool


def calibrate_standards(asked: Asked) -> list[str]:
    """Run the command; what to print. Raises ValueError with one line for each problem, OSError."""
    from ..batch.versions import versions
    from ..calibration.calibrate import Calibrated, calibrate
    from ..calibration.calibration import Calibration, Card, to_text
    from ..calibration.signals import total_light
    from ..calibration.standards import read_standards, spectra_of

    own_lines(asked.lines)
    response = known_response(asked.response)
    choices, closed = _choices(asked), _closure(asked.closure)
    if closed is not None and (choices.of_lines or asked.model is not None):
        raise ValueError(
            "--closure takes all lines: leave out --normalise, --line, --curve and --model"
        )
    text = _text(asked.standards)
    standards = read_standards(text, asked.standards.name)
    table = asked.standards if _in_table(asked, standards) else None
    spectra = (
        {one.sample: [asked.standards] for one in standards.samples}
        if table
        else spectra_of(standards, _spectra(asked), asked.standards.name)
    )
    asked.output.parent.mkdir(parents=True, exist_ok=True)  # before the work, in case it cannot be
    rows = standards.rows if table else ()
    shots, axis = _shots(spectra, standards.elements, response, rows)
    found = calibrate(standards, shots, choices) if closed is None else Calibrated({}, [], [], [])
    points = {} if closed is None else _one_point(standards, shots)
    if not found.elements and closed is None:
        raise ValueError(
            "\n".join(["no element can be calibrated", *found.refused, *_or_one_point(shots)])
        )
    light = [total_light(shot.reduction) for own in shots.values() for shot in own]
    card = Card(
        asked.by or _user(), datetime.now(UTC).astimezone().isoformat(timespec="seconds"),
        versions()["labrun"], asked.standards.name, sha256(text.encode()).hexdigest(),
        sum(bool(own) for own in shots.values()), len(light), asked.note, *axis,
        (min(light), max(light)), sha256_of(response),
    )  # fmt: skip
    made = Calibration(card, found.elements, likeness=found.likeness, closed=closed, points=points)
    asked.output.write_text(to_text(made), encoding="utf-8")
    drawn = asked.figures and closed is None
    written = [asked.output, *(_drawn(made, asked.output) if drawn else [])]
    without = [sample for sample, own in spectra.items() if not own]
    return [
        *(_table(made) if closed is None else _points_table(made)),
        *(f"left out: {sentence}" for sentence in found.left_out),
        *(f"not calibrated: {sentence}" for sentence in found.refused),
        *(f"note: {note}" for note in (*standards.notes, *found.notes)),
        *([f"note: {_NO_PLS}"] if closed is None and choices.pls is False and asked.model is None else []),
        *([f"note: no spectrum of {', '.join(without)}"] if without else []),
        _LIMITS if closed is None else _CLOSED,
        *(f"wrote {path}" for path in written),
        f"use it with: labrun reduce SPECTRA --calibration {asked.output}",
    ]  # fmt: skip


def _text(table: Path) -> str:
    content = table.read_bytes()
    if content.startswith((_ZIP, _OLD_EXCEL)):
        raise ValueError(f"{table}: it is a workbook; save its sheet as CSV in UTF-8")
    marked = content.startswith((BOM_UTF16_LE, BOM_UTF16_BE))
    for encoding in ("utf-16",) if marked else ("utf-8-sig", "cp1252"):  # as spreadsheets save it
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if "\0" not in text:
                return text
    raise ValueError(f"{table}: it is not text; save it as CSV in UTF-8")


_ZIP, _OLD_EXCEL = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
_LIMITS = (
    "LOD and LOQ are those of one shot: 3 and 10 standard deviations of the signal at 0, by the "
    "scatter of shots and of standards, over the slope; RMSECV leaves one standard out at a time"
)
_CLOSED = (
    "amounts of the Saha-Boltzmann plot are multiplied by these factors and closed to 100 %: all that a "
    "sample holds has to have lines in the plot, and its plasma to be like the standards'"
)
_NO_PLS = (
    "whole spectra (PLS) were not tried, and how spectra are like the standards' is not known: "
    f"{missing('quant')}"
)


def _choices(asked: Asked) -> Any:
    from ..calibration.calibrate import Choices
    from ..calibration.calibration import AREA, LIGHT
    from ..lines.symbols import SYMBOLS

    ways = {"none": AREA, "light": LIGHT, None: None}
    if asked.normalise not in ways and asked.normalise not in SYMBOLS:
        raise ValueError(
            f"--normalise {asked.normalise}: write none, light, or the symbol of an internal standard"
        )
    if asked.curve not in (None, "straight", "quadratic"):
        raise ValueError(f"--curve {asked.curve}: write straight or quadratic")
    lines = {}
    for text in asked.lines_nm:
        symbol, _, nm = text.partition("=")
        try:
            lines[symbol.strip()] = float(nm)
        except ValueError:
            raise ValueError(f"--line {text}: write it as Li=610.36 (nm, in air)") from None
    degree = {None: None, "straight": 1, "quadratic": 2}[asked.curve]
    by = ways.get(asked.normalise, asked.normalise)
    return Choices(by, lines, degree, _whole_spectra(asked, by or lines or degree))


def _one_point(standards: Any, shots: Mapping[str, Any]) -> Any:
    """A factor for each element's amount, from standards of which most of the mass is known."""
    from ..calibration.closure import one_point

    points = one_point(
        [
            (one.wt_percent, [shot.reduction for shot in shots.get(one.sample, ())])
            for one in standards.samples
        ]
    )
    if not points:
        raise ValueError(
            "no one-point calibration: no spectrum's lines tell the amounts of two elements of a known "
            "concentration or more"
        )
    return points


def _or_one_point(shots: Mapping[str, Any]) -> list[str]:
    if sum(bool(own) for own in shots.values()) != 1:
        return []
    return [
        "one standard makes no curve; --closure oxides (or elements) makes a one-point calibration"
    ]


def _points_table(made: Any) -> list[str]:
    from math import exp

    return [
        f"{name:>4} amount times {exp(one.log_factor):.3g}, ± {100 * one.error:.0f} % from shot to shot"
        for name, one in made.points.items()
    ]


def _whole_spectra(asked: Asked, of_lines: Any) -> bool | None:
    """Whether elements are read from whole spectra: None is where that is better."""
    if asked.model not in (None, "lines", "pls"):
        raise ValueError(f"--model {asked.model}: write lines or pls")
    absent = missing("quant")
    if asked.model == "pls":
        if of_lines:
            raise ValueError(
                "--model pls reads whole spectra: leave out --normalise, --line, --curve"
            )
        if absent is not None:
            raise ValueError(f"--model pls: {absent}")
        return True
    return False if asked.model == "lines" or absent is not None else None


def _spectra(asked: Asked) -> list[Path]:
    from ..batch.gather import gather

    absent = [path for path in asked.files if not path.exists()]
    if absent:
        raise ValueError("\n".join(f"{path} does not exist" for path in absent))
    table = asked.standards.resolve()
    gathered = gather(asked.files, asked.output.resolve().parent / "reduced")
    say_skipped(gathered)
    found = [one.path for one in gathered.spectra if one.path.resolve() != table]
    if not found:
        raise ValueError(f"no spectrum found in {', '.join(map(str, asked.files))}")
    if told := unread(found)[0]:
        raise ValueError("\n".join(told))
    return found


def _in_table(asked: Asked, standards: Any) -> bool:
    """Whether the spectra are those in the table of standards, which is given for both."""
    table = asked.standards.resolve()
    return bool(standards.rows) and all(path.resolve() == table for path in asked.files)


def _shots(
    spectra: Mapping[str, list[Path]],
    elements: list[str],
    response: str | None,
    rows: Sequence[str],
) -> tuple[dict[str, Any], tuple[int, float, float]]:
    """The reduced shots of each sample, and the axis that all have: channels, first and last nm.

    rows: the sample of each spectrum of the one file that has those of all; empty for others.
    """
    from ..calibration.calibrate import Shot
    from ..calibration.calibration import asked_for
    from ..elements.elements import predominant_line
    from ..reduce import reduce_spectrum
    from ..spectrum.read import read_shots
    from ..spectrum.response import read_response

    wanted = asked_for([element for element in elements if _can(predominant_line, element)], None)
    samples = {path: sample for sample, paths in spectra.items() for path in paths}
    named = {sample.casefold(): sample for sample in spectra}
    say(f"{len(samples)} files of {len(spectra)} standards")
    shots: dict[str, Any] = {sample: [] for sample in spectra}
    axes: dict[Path, tuple[int, float, float]] = {}
    problems = []
    for path, sample in samples.items():
        try:
            found = read_shots(path)
            if rows and len(rows) != len(found):
                raise ValueError(
                    f"{len(found)} of its {len(rows)} rows have a spectrum; leave the others out"
                )
            x = found.wavelength_nm
            axes[path] = len(x), round(float(x[0]), 3), round(float(x[-1]), 3)
            for k, one in enumerate(found.each()):
                spectrum = one if response is None else read_response(response).divided_out(one)
                name = f"{path.name}, shot {k + 1}" if len(found) > 1 else path.name
                own = named[rows[k].casefold()] if rows else sample
                shots[own].append(Shot(name, reduce_spectrum(spectrum, wanted)))
        except ValueError as fault:
            problems.append(f"{path}: {fault}")
    usual = Counter(axes.values()).most_common(1)[0][0] if axes else (0, 0.0, 0.0)
    problems += [
        f"{path}: {n:,} channels from {first} to {last} nm, where most spectra have {usual[0]:,} from "
        f"{usual[1]} to {usual[2]} nm; a calibration is of one instrument"
        for path, (n, first, last) in axes.items()
        if (n, first, last) != usual
    ]
    if problems:
        raise ValueError("\n".join(problems))
    return shots, usual


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # nobody has this number, as in some containers
        return ""


def _can(line: Any, element: str) -> bool:
    try:
        line(element)
    except ValueError:
        return False
    return True


def _table(made: Any) -> list[str]:
    from ..lines.air import to_air

    rows = [("", "line (air)", "signal", "curve", "standards, wt %", "LOD", "LOQ", "RMSECV")]
    for name, one in made.elements.items():
        nm = "" if one.line is None else f"{float(to_air(one.line.wavelength_nm)):.3f}"
        kind = "straight" if len(one.curve.coefficients) == 2 else "quadratic"
        kind = kind if one.pls is None else f"PLS, {one.pls.components} components"
        rows.append((
            name, nm, one.by, kind,
            f"{len(one.points)}, {one.lowest:.3g} to {one.curve.highest:.3g}",
            f"{one.lod:.2g}", f"{one.loq:.2g}", f"{one.rmsecv:.2g}",
        ))  # fmt: skip
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(c.ljust(w) for c, w in zip(row, wide, strict=True)).rstrip() for row in rows]


def _drawn(made: Any, output: Path) -> list[Path]:
    from ..figures.calibration_curves import calibration_figure
    from ..figures.paper import paper, save
    from ..figures.whole_spectra import whole_spectra_figure

    with paper():
        drawn = [save(calibration_figure(made), output.with_suffix(".png"))]
        if made.likeness is not None:
            beside = output.with_name(f"{output.stem}_spectra.png")
            drawn.append(save(whole_spectra_figure(made), beside))
    return drawn
