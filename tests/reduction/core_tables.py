"""A run over the simulated core as a folder: data.csv, spectra, and the tables of their reduction."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.reduction import Reduction, read_spectrum, reduce_spectrum
from labrun.reduction.figures.peak_names import peak_names
from labrun.reduction.tables.plot import cation_fraction

ELEMENTS = ("Li", "H", "K", "Na", "Si", "Al", "Rb", "Mg")
COLUMNS, ROWS, PITCH_MM = 24, 12, 0.2
ORIGIN_MM = 6.0, 10.0
PEAKS = (
    "spectrum,center_nm,area,area_err,sigma_nm,gamma_nm,fwhm_nm,height,snr,chi2,element,stage,"
    "line_nm,flags"
)
FOUND = (
    "spectrum,element,status,score,lines_matched,lines_expected,area,line_nm,confounders,"
    "detection_limit"
)
PLASMA = (
    "spectrum,temperature_k,temperature_err,log10_ne,log10_ne_err,"
    "li_cation_fraction,li_cation_fraction_err,method,flags"
)
USUAL_NM = {"Li": 670.78, "H": 656.28, "K": 766.49, "Na": 589.0, "Si": 288.16, "Al": 396.15,
            "Rb": 780.03, "Mg": 279.55}  # fmt: skip


@dataclass(frozen=True)
class Run:
    """folder: of the run; mineral: of each row of data.csv, as the core has it."""

    folder: Path
    mineral: np.ndarray


def make_run(folder: Path) -> Run:
    """Shoot 24 x 12 points, and reduce every spectrum."""
    maker = ShotMaker(core=3, seed=0)
    (folder / "spectra").mkdir()
    tables: dict[str, list] = {"data": [], "peaks": [], "elements": [], "plasma": []}
    minerals = []
    for n in range(COLUMNS * ROWS):
        row, column = divmod(n, COLUMNS)
        x, y = column * PITCH_MM, row * PITCH_MM
        place = {"x": x + ORIGIN_MM[0], "y": y + ORIGIN_MM[1]}
        name = f"spectra/core_{column}_{row}.csv"
        (folder / name).write_bytes(maker.csv({"n": n + 1, "focus": 1.0, **place}))
        minerals.append(maker.core.mineral_at(place["x"], place["y"]))
        tables["data"].append([f"{column},{row}", f"{x:.1f}", f"{y:.1f}", "succeeded"])
        add(tables, name, reduce_spectrum(read_spectrum(folder / name), ELEMENTS))
    write(folder / "data.csv", "key,x_mm,y_mm,fate", tables["data"])
    (folder / "reduced").mkdir()
    for name, head in (("peaks", PEAKS), ("elements", FOUND), ("plasma", PLASMA)):
        write(folder / "reduced" / f"{name}.csv", head, tables[name])
    return Run(folder, np.array(minerals))


def add(tables: dict[str, list], name: str, reduction: Reduction) -> None:
    """The rows of one spectrum, in the columns that `labrun reduce` writes."""
    peaks = reduction.peaks
    for k, named in enumerate(peak_names(reduction)):
        element, stage, _ = named.split() if named else ("", "", "")
        nm = f"{peaks.centre_nm[k]:.4f}"
        tables["peaks"].append([
            name, nm, f"{peaks.area[k]:.7g}", f"{peaks.area_error[k]:.4g}", peaks.sigma_nm[k],
            peaks.gamma_nm[k], peaks.fwhm_nm[k], 0, 0, f"{peaks.chi2[k]:.4g}", element,
            {"I": 1, "II": 2}.get(stage, ""), nm if element else "", "",
        ])  # fmt: skip
    hydrogen = reduction.identified.hydrogen if reduction.identified else None
    for element in ELEMENTS:
        area = reduction.areas[element]
        if element == "H":  # too broad for the window of an ordinary peak
            area = hydrogen.area if hydrogen else 0.0
        status = reduction.evidence[element].status
        tables["elements"].append(
            [name, element, status, 0, 0, 0, f"{area:.7g}", USUAL_NM[element], "", 1]
        )
    plasma, lithium = reduction.plasma, cation_fraction(reduction)
    assert plasma is not None
    tables["plasma"].append([
        name, plasma.temperature_k, plasma.temperature_error_k, plasma.log10_ne,
        plasma.log10_ne_error, *((lithium.share, lithium.share_error) if lithium else ("", "")),
        plasma.method, "",
    ])  # fmt: skip


def write(path: Path, head: str, rows: list) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head.split(","))
        writer.writerows(rows)
