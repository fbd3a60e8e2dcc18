"""How the reduction commands print messages and read lists."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from ..lines.formula import Closed

OwnLines = Annotated[
    Path | None,
    typer.Option(
        "--lines", metavar="CSV", show_default=False,
        help="Lines of your own besides the table's: as `labrun lines` names the columns, or as "
        "NIST's database exports them.",
    ),
]  # fmt: skip
KnownResponse = Annotated[
    Path | None,
    typer.Option(
        "--response", metavar="CSV", show_default=False,
        help="The instrument's response, which is divided out: as `labrun calibrate response` writes it.",
    ),
]  # fmt: skip
Calibrated = Annotated[
    Path | None,
    typer.Option(
        "--calibration", metavar="JSON", show_default=False,
        help="Concentrations by a calibration: as `labrun calibrate standards` writes it.",
    ),
]  # fmt: skip
FAILED, PROBLEMS = 1, 2  # exit status: something could not be written; wrong usage or input
Closure = Annotated[
    str | None,
    typer.Option(
        help="Concentrations closed to 100 %: oxides (a rock) or elements (an alloy); by one standard "
        "or more for `calibrate standards`, without any else.",
        metavar="WHAT", show_default=False,
    ),
]  # fmt: skip


def say(text: str) -> None:
    """Print one line to stderr; stdout is for what a program reads."""
    typer.echo(f"labrun: {text}", err=True)


def counted(n: int, thing: str) -> str:
    """`1 point`, `2 points`, `2 classes`."""
    return f"{n} {thing}" + ("" if n == 1 else "es" if thing.endswith("s") else "s")


def listed(text: str) -> tuple[str, ...]:
    """`Li, K,Si` as its parts, each once."""
    return tuple(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))


def columns(text: str | None) -> tuple[str, ...] | None:
    """The columns of `--columns`, None if it was not given; ValueError for fewer than two."""
    if text is None:
        return None
    found = listed(text)
    if len(found) < 2:
        raise ValueError(
            f"--columns {text}: write the column of the wavelengths and that of the counts, by "
            "number or heading, as in --columns 1,3"
        )
    return found


def own_lines(path: Path | None) -> str | None:
    """The text of `--lines`, which is used from now on, its notes said; ValueError if it cannot be."""
    from ..lines.lines import use_lines

    if path is None:
        use_lines(None)
        return None
    notes: list[str] = []
    text = _text_for(lambda text: notes.extend(use_lines(text)), "--lines", path)
    for note in notes:
        say(f"--lines {path}: {note}")
    return text


def known_response(path: Path | None) -> str | None:
    """The text of `--response`; ValueError if it cannot be used."""
    if path is None:
        return None
    from ..spectrum.response import read_response

    return _text_for(read_response, "--response", path)


def closure(closed: str | None) -> "Closed | None":
    """What `--closure` closes; ValueError if it is nothing that can be."""
    from ..lines.formula import CLOSED

    if closed is None or closed in CLOSED:
        return closed
    raise ValueError(f"--closure {closed}: choose {' or '.join(CLOSED)}")


def calibration(path: Path | None, response: str | None) -> str | None:
    """The text of `--calibration`; ValueError if it cannot be used with that text of `--response`."""
    if path is None:  # most often: what reads one takes a second to load
        return None
    from ..calibration.calibration import read_calibration

    text = _text_for(read_calibration, "--calibration", path)
    if how := read_calibration(text).other_response(sha256_of(response), "--response"):
        raise ValueError(f"--calibration {path}: it was made {how}")
    return text


def sha256_of(text: str | None) -> str | None:
    """By which an option's text is recognised."""
    return None if text is None else sha256(text.encode()).hexdigest()


def _text_for(reader: Callable[[str], object], option: str, path: Path) -> str:
    """The text of an option's file, once `reader` has taken it; ValueError that names both if not."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        reader(text)
    except OSError as fault:
        raise ValueError(f"{option} {path}: {fault.strerror or fault}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{option} {path}: it is not text") from None
    except ValueError as fault:
        raise ValueError(f"{option} {path}: {fault}") from None
    return text


def symbols(text: str | None, option: str) -> tuple[str, ...] | None:
    """The elements of an option, None if it was not given; ValueError if it names none."""
    if text is None:
        return None
    from ..lines.symbols import SYMBOLS

    found = listed(text)
    odd = [name for name in found if name not in SYMBOLS]
    if odd or not found:
        what = f"{odd[0]!r} is not an element symbol" if odd else "it names no element"
        raise ValueError(f"{option} {text}: {what}; write it as Li,K,Si")
    return found
