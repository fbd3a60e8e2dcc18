"""The rows that `labrun lines` prints, as a table for people or JSON for programs."""

import difflib
import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .say import FAILED, PROBLEMS, say
from .words import own_lines

MEDIA = ("air", "vacuum")
ROMAN = {1: "I", 2: "II"}
COLDEST_K, HOTTEST_K = 1_000.0, 100_000.0


@dataclass(frozen=True, slots=True)
class Wanted:
    """The command line."""

    element: str
    from_nm: float | None
    to_nm: float | None
    stage: int | None
    medium: str
    temperature_k: float
    density_per_cm3: float
    strongest: int | None


def list_lines(wanted: Wanted, own: Path | None, as_json: bool) -> int:
    """Print the lines by ascending wavelength; return the exit status, 1 if there are none."""
    try:
        own_lines(own)
        fault = _fault(wanted)
    except ValueError as wrong:
        fault = str(wrong)
    if fault:
        say(fault)
        return PROBLEMS
    rows = rows_of(wanted)
    if as_json:
        print(json.dumps(rows, indent=1))
    elif rows:
        _print(rows, wanted)
    else:
        say(f"the table has no matching line of {wanted.element.capitalize()}")
    return 0 if rows else FAILED


def rows_of(wanted: Wanted) -> list[dict[str, Any]]:
    """One dictionary per line: wavelengths in nm, energies in eV, A per second, strength 0 to 100."""
    import numpy as np

    from ..lines.air import in_medium
    from ..lines.lines import lines_of
    from ..plasma.plasma import relative_strengths

    table = lines_of(wanted.element.capitalize())
    strength = relative_strengths(table, wanted.temperature_k, wanted.density_per_cm3)
    strength = 100.0 * strength / max(float(strength.max()), 1e-300)
    nm = in_medium(table.wavelength_nm, "vacuum" if wanted.medium == "vacuum" else "air")
    chosen = np.ones(len(table), dtype=bool)
    if wanted.from_nm is not None:
        chosen &= nm >= wanted.from_nm
    if wanted.to_nm is not None:
        chosen &= nm <= wanted.to_nm
    if wanted.stage is not None:
        chosen &= table.stage == wanted.stage
    rows = np.flatnonzero(chosen)
    if wanted.strongest is not None:
        rows = np.sort(rows[np.argsort(-strength[rows], kind="stable")[: wanted.strongest]])
    return [
        {
            "element": str(table.element[row]),
            "stage": int(table.stage[row]),
            "wavelength_nm": round(float(nm[row]), 4),
            "a_ki_per_s": float(table.a_ki_per_s[row]),
            "accuracy": str(table.accuracy[row]),
            "e_i_ev": round(float(table.e_i_ev[row]), 5),
            "e_k_ev": round(float(table.e_k_ev[row]), 5),
            "g_i": int(table.g_i[row]),
            "g_k": int(table.g_k[row]),
            "strength": float(f"{strength[row]:.4g}"),
        }
        for row in rows
    ]


def _print(rows: list[dict[str, Any]], wanted: Wanted) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    table.add_column("line", style="bold")
    for title in (f"nm ({wanted.medium})", "A_ki (1/s)", "accuracy", "E_i (eV)", "E_k (eV)"):
        table.add_column(title, justify="left" if title == "accuracy" else "right")
    for title in ("g_i", "g_k", "strength"):
        table.add_column(title, justify="right")
    for row in rows:
        table.add_row(
            f"{row['element']} {ROMAN[row['stage']]}", f"{row['wavelength_nm']:.4f}",
            f"{row['a_ki_per_s']:.3g}", row["accuracy"], f"{row['e_i_ev']:.4f}",
            f"{row['e_k_ev']:.4f}", str(row["g_i"]), str(row["g_k"]), f"{row['strength']:.3g}",
        )  # fmt: skip
    if sys.stdout.isatty():
        Console(highlight=False).print(table)
    else:
        Console(highlight=False, width=200).print(table)  # never truncated in a pipe


def _fault(wanted: Wanted) -> str | None:
    from ..lines.lines import line_table

    symbols = set(line_table().element.tolist())
    element = wanted.element.capitalize()
    if element not in symbols:
        near = difflib.get_close_matches(element, sorted(symbols), 3, 0.4)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        return f"the table has no lines of {wanted.element!r}{hint}"
    if wanted.medium not in MEDIA:
        return f"--medium {wanted.medium}: choose air or vacuum"
    if wanted.stage not in (None, *ROMAN):
        return f"--stage {wanted.stage}: choose 1 for atoms (I) or 2 for ions (II)"
    if wanted.from_nm is not None and wanted.to_nm is not None and wanted.from_nm > wanted.to_nm:
        return f"--from {wanted.from_nm:g} is greater than --to {wanted.to_nm:g}"
    if wanted.strongest is not None and wanted.strongest < 1:
        return f"--strongest {wanted.strongest}: must be at least 1"
    if not COLDEST_K <= wanted.temperature_k <= HOTTEST_K:
        return f"--temperature {wanted.temperature_k:g}: must be {COLDEST_K:g} to {HOTTEST_K:g} K"
    if not (wanted.density_per_cm3 > 0 and math.isfinite(wanted.density_per_cm3)):
        return f"--density {wanted.density_per_cm3:g}: must be above 0 electrons per cm3"
    return None
