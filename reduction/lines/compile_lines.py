"""Compile the table of atomic lines from the NIST data in `libskit`.

Run it by hand: `python -m pip install libskit==0.2 && python -m labrun.reduction.lines.compile_lines`.
Nothing imports it; its output, `data/lines.npz`, is committed, and so is `data/more_lines.csv`: lines
that libskit lacks, from the literature. `data/SOURCES.md` names the sources.
"""

import csv
import sys
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from math import nan
from pathlib import Path

import numpy as np

from .more_lines import read_lines
from .table import COLUMNS, LineTable

DATA = Path(__file__).parent.parent / "data"
RANGE_NM = (190.0, 961.0)
ISOTOPES = ("D", "T")  # their lines are those of H, shifted by less than 0.3 nm
ROMAN = {"I": 1, "II": 2}
# STARK-B and NIST agree on Ritz wavelengths and energies to within this.
SAME_NM = 1e-4
SAME_EV = 1e-5

Row = dict[str, str]


def libskit_data() -> Path:
    """The folder of CSV files in the installed libskit, found without importing it."""
    spec = find_spec("libskit")
    if spec is None or spec.origin is None:
        sys.exit("libskit is not installed: python -m pip install libskit==0.2")
    return Path(spec.origin).parent / "data"


def rows_of(path: Path) -> Iterator[Row]:
    with path.open(newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def why_not(row: Row) -> str | None:
    """Why a NIST row is left out, or None."""
    if int(row["sp_num"]) not in ROMAN.values():
        return "stage III or higher"
    if row["Type"]:
        return "not E1 (M1, E2, M2, two-photon, hyperfine, unresolved)"
    if not row["Aki(s^-1)"]:
        return "no transition probability"
    if not (row["ritz_wl_vac(nm)"] and row["Ei(eV)"] and row["Ek(eV)"]):
        return "no levels"
    if not RANGE_NM[0] <= float(row["ritz_wl_vac(nm)"]) <= RANGE_NM[1]:
        return "outside 190-961 nm"
    if row["element"] in ISOTOPES:
        return "deuterium or tritium"
    if int(float(row["g_i"])) == int(float(row["g_k"])) == 1:
        return "placeholder weights 1 and 1 (J = 0 to 0 is forbidden)"
    # NIST lists H as averages over n (configuration "2") and as fine structure ("2p").
    if row["element"] == "H" and not row["conf_i"].isdigit():
        return "fine structure of H, also included as an average"
    return None


def stark_widths(folder: Path) -> dict[tuple[str, int], list[Row]]:
    """STARK-B rows by species."""
    species: dict[tuple[str, int], list[Row]] = {}
    for row in rows_of(folder / "lines_processed_all.csv"):
        species.setdefault((row["element"], int(row["sp_num"])), []).append(row)
    return species


def stark_of(line: Row, candidates: list[Row]) -> tuple[float, float, float, float]:
    """Density (per cm3) and coefficients a0 a1 a2 of the Stark width, NaN if there is none."""
    for row in candidates:
        if (
            abs(float(row["ritz_wl_vac(nm)"]) - float(line["ritz_wl_vac(nm)"])) < SAME_NM
            and abs(float(row["Ei(eV)"]) - float(line["Ei(eV)"])) < SAME_EV
            and abs(float(row["Ek(eV)"]) - float(line["Ek(eV)"])) < SAME_EV
            and (int(row["g_i"]), int(row["g_k"])) == (int(line["g_i"]), int(line["g_k"]))
        ):
            a0, a1, a2 = (float(row[f"electron a{n}"]) for n in range(3))
            return float(row["N (cm-3)"]), a0, a1, a2
    return nan, nan, nan, nan


def compile_lines(folder: Path) -> tuple[LineTable, Counter[str]]:
    """The lines, ascending in wavelength, and the number of rows left out per reason."""
    left_out: Counter[str] = Counter()
    kept: list[Row] = []
    for row in rows_of(folder / "nist_asd_lines_vacuum.csv"):
        reason = why_not(row)
        if reason:
            left_out[reason] += 1
        else:
            kept.append(row)
    kept.sort(key=lambda row: (float(row["ritz_wl_vac(nm)"]), row["element"], row["Ek(eV)"]))
    widths = stark_widths(folder)
    stark = np.array(
        [stark_of(row, widths.get((row["element"], int(row["sp_num"])), [])) for row in kept]
    )

    def floats(column: str) -> np.ndarray:
        return np.array([float(row[column]) for row in kept], dtype=np.float64)

    arrays = {
        "element": np.array([row["element"] for row in kept], dtype="U2"),
        "stage": np.array([int(row["sp_num"]) for row in kept], dtype=np.int8),
        "wavelength_nm": floats("ritz_wl_vac(nm)"),
        "a_ki_per_s": floats("Aki(s^-1)"),
        "g_i": floats("g_i"),
        "g_k": floats("g_k"),
        "e_i_ev": floats("Ei(eV)"),
        "e_k_ev": floats("Ek(eV)"),
        "accuracy": np.array([row["Acc"] for row in kept], dtype="U3"),
        "stark_density_per_cm3": stark[:, 0],
        "stark_a": stark[:, 1:],
    }
    more = read_lines((DATA / "more_lines.csv").read_text(encoding="utf-8"))
    return LineTable(**arrays).with_lines(more), left_out


def compile_species(folder: Path) -> dict[str, np.ndarray]:
    """Ionisation energies and levels of each (element, stage I or II), flattened with offsets."""
    limits = {
        row["Sp. Name"]: float(row["Ionization Energy (b) (eV)"])
        for row in rows_of(folder / "ionization_energies_processed.csv")
        if row["Ionization Energy (b) (eV)"]
    }
    levels: dict[str, list[tuple[float, float]]] = {}
    for row in rows_of(folder / "levels_processed.csv"):
        levels.setdefault(row["Sp. Name"], []).append((float(row["Level (eV)"]), float(row["g"])))
    names = [
        (element, roman)
        for element in sorted({name.split()[0] for name in levels} - set(ISOTOPES))
        for roman in ROMAN
        if f"{element} {roman}" in levels and f"{element} I" in limits
    ]
    flat = [sorted(levels[f"{element} {roman}"]) for element, roman in names]
    ends = np.cumsum([0, *(len(found) for found in flat)])
    return {
        "species_element": np.array([element for element, _ in names], dtype="U2"),
        "species_stage": np.array([ROMAN[roman] for _, roman in names], dtype=np.int8),
        "species_ionisation_ev": np.array(
            [limits.get(f"{element} {roman}", np.nan) for element, roman in names]
        ),
        "level_offset": ends.astype(np.int64),
        "level_ev": np.array([energy for found in flat for energy, _ in found]),
        "level_g": np.array([weight for found in flat for _, weight in found]),
    }


def main() -> None:
    folder = libskit_data()
    lines, left_out = compile_lines(folder)
    species = compile_species(folder)
    arrays = {name: getattr(lines, name) for name in COLUMNS}
    np.savez_compressed(DATA / "lines.npz", allow_pickle=False, **arrays, **species)
    print(f"{len(lines)} lines of {len(set(lines.element.tolist()))} elements,")
    print(f"{np.isfinite(lines.stark_density_per_cm3).sum()} with a Stark width,")
    print(f"{len(species['level_ev'])} levels of {len(species['species_stage'])} species")
    for reason, count in left_out.most_common():
        print(f"{count:8d} left out: {reason}")


if __name__ == "__main__":
    main()
