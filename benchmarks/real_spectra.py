"""Print what a reduction finds in measured spectra whose material is known, beside what it should.

    python benchmarks/real_spectra.py FOLDER        every spectrum, and the totals of either half
    python benchmarks/real_spectra.py FOLDER Al Cu  only spectra whose names begin so, with evidence

FOLDER holds `truth.csv` (file, what, elements of the ideal formula) and the spectra themselves;
no measured spectrum is in this repository. Rows of `truth.csv` alternate between two halves:
settings are chosen on the first, and the second tells what they are worth.
"""

import csv
import sys
import time
from pathlib import Path

import numpy as np

from labrun.reduction import Reduction, read_spectrum, reduce_spectrum

# Hard for any analyser in air: neither finding nor missing them counts.
HARD = frozenset(("H", "C", "N", "O", "F", "S", "Cl", "Ar"))
# In no common rock's formula or traces, and no neighbour of common ores. Some have hosts.
IMPLAUSIBLE = frozenset(
    [
        *("He", "Be", "Ne", "Sc", "Ga", "Ge", "Se", "Br", "Kr", "Y", "Nb", "Tc", "Ru", "Rh", "Pd"),
        *("In", "Te", "I", "Xe", "La", "Ce", "Pr", "Nd", "Pm", "Sm", "Eu", "Gd", "Tb", "Dy", "Ho"),
        *("Er", "Tm", "Yb", "Lu", "Hf", "Ta", "Re", "Os", "Ir", "Pt", "Au", "Hg", "Tl", "Bi", "Po"),
        *("At", "Rn", "Fr", "Ra", "Ac", "Th", "Pa", "U"),
    ]
)
HOSTS = {
    "zircon": "Hf Y Sc Yb Lu Th U Ce", "apatite": "La Ce Nd Y Th", "molybdenite": "Re",
    "galena": "Bi Tl", "sphalerite": "In Ga Ge", "fluorite": "Y La Ce Eu", "titanite": "Y Ce Nb",
    "monazite": "La Ce Nd Pr Sm Th Y", "beryl": "Be Sc", "rutile": "Nb Ta", "columbite": "Nb Ta Sc",
}  # fmt: skip


def main() -> None:
    folder, names = Path(sys.argv[1]), tuple(sys.argv[2:])
    with (folder / "truth.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    halves: list[list[int]] = [[0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]
    begin = time.process_time()
    for number, row in enumerate(rows):
        if names and not row["file"].startswith(names):
            continue
        expected = set(row["elements_of_ideal_formula"].split())
        found = reduce_spectrum(read_spectrum((folder / row["file"]).read_bytes()))
        total = halves[number % 2]
        for k, n in enumerate(told(row, expected, found)):
            total[k] += n
        if names:
            explain(found, expected)
    print(f"{time.process_time() - begin:.0f} s of the processor")
    for name, total in (("first half", halves[0]), ("second half", halves[1]),
                        ("all", [a + b for a, b in zip(*halves, strict=True)])):  # fmt: skip
        due, there, wrong, metals, metals_found = total
        print(
            f"{name}: {there} of {due} expected elements (recall {there / max(due, 1):.3f}), "
            f"{wrong} implausible, {metals_found} of {metals} metals contain themselves"
        )


def told(row: dict[str, str], expected: set[str], found: Reduction) -> tuple[int, ...]:
    """A line for one spectrum; how much was due, found, and implausible; metal; metal found."""
    detected, counted = set(found.detected), expected - HARD
    hosts = set(HOSTS.get(row["what"], "").split())
    wrong = (detected & IMPLAUSIBLE) - expected - hosts
    others = detected - expected - wrong - HARD
    metal = row["what"] == "pure metal"
    offsets = "" if found.identified is None else "offsets " + " ".join(
        f"{1e3 * v:+.0f}" for v in found.identified.offsets.at(KNOTS_NM)
    )  # fmt: skip
    print(
        f"{row['file'].split('_')[0]:<16} found {' '.join(sorted(detected & counted)) or '-':<16} "
        f"missed {' '.join(sorted(counted - detected)) or '-':<10} "
        f"implausible {' '.join(sorted(wrong)) or '-':<8} others {' '.join(sorted(others)) or '-'}; "
        f"{found.n_peaks} peaks, {found.temperature_k or 0:.0f} K, {offsets} pm, {found.medium}"
    )
    return len(counted), len(detected & counted), len(wrong), metal, metal and counted <= detected


KNOTS_NM = np.array([220.0, 270, 330, 395, 450, 500, 590, 700, 770])


def explain(found: Reduction, expected: set[str]) -> None:
    for said in sorted(found.evidence.values(), key=lambda said: -said.score):
        if said.status != "absent" or said.element in expected:
            print(
                f"    {said.element:<3}{said.status:<10}{said.score:8.1f}  "
                f"{said.lines_matched} of {said.lines_expected} lines, {said.line_nm:.2f} nm, "
                f"area {said.area:.3g} +- {said.area_error:.2g}, beside {' '.join(said.confounders)}"
            )
    for note in found.notes:
        print("    " + note)


if __name__ == "__main__":
    main()
