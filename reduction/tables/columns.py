"""The columns of every table, with their units: docs/reference/reduction-tables.md repeats them."""

from dataclasses import dataclass
from typing import Any, Literal

Kind = Literal["text", "whole", "number"]


@dataclass(frozen=True, slots=True)
class Column:
    """decimals or digits: how a number is rounded, by decimal places or significant digits."""

    name: str
    kind: Kind
    unit: str
    decimals: int | None = None
    digits: int | None = None


def text(name: str) -> Column:
    return Column(name, "text", "")


def whole(name: str) -> Column:
    return Column(name, "whole", "")


def number(
    name: str, unit: str = "", decimals: int | None = None, digits: int | None = None
) -> Column:
    return Column(name, "number", unit, decimals, digits)


FILES = (
    text("spectrum"),
    text("status"),
    text("reason"),
    whole("channels"),
    number("first_nm", "nm", decimals=4),
    number("last_nm", "nm", decimals=4),
    whole("bad_channels"),
    whole("saturated_channels"),
    text("medium"),
    number("offset_low_nm", "nm", decimals=4),
    number("offset_high_nm", "nm", decimals=4),
    whole("n_peaks"),
    text("notes"),
)
PEAKS = (
    text("spectrum"),
    number("center_nm", "nm", decimals=5),
    number("area", "counts nm", digits=7),
    number("area_err", "counts nm", digits=4),
    number("sigma_nm", "nm", digits=5),
    number("gamma_nm", "nm", digits=5),
    number("fwhm_nm", "nm", digits=5),
    number("height", "counts", digits=6),
    number("snr", digits=5),
    number("chi2", digits=5),
    text("element"),
    whole("stage"),
    number("line_nm", "nm", decimals=4),
    text("flags"),
)
ELEMENTS = (
    text("spectrum"),
    text("element"),
    text("status"),
    number("score", decimals=2),
    whole("lines_matched"),
    whole("lines_expected"),
    number("area", "counts nm", digits=7),
    number("line_nm", "nm", decimals=4),
    text("confounders"),
    number("detection_limit", "counts nm", digits=5),
    number("wt_percent", "wt %", digits=5),
    number("wt_percent_err", "wt %", digits=4),
    number("wt_percent_low", "wt %", digits=4),
    number("wt_percent_high", "wt %", digits=4),
    text("wt_percent_flags"),
)
PLASMA = (
    text("spectrum"),
    number("temperature_k", "K", decimals=1),
    number("temperature_err", "K", decimals=1),
    number("log10_ne", "per cm3", decimals=3),
    number("log10_ne_err", decimals=3),
    number("li_cation_fraction", decimals=5),
    number("li_cation_fraction_err", decimals=5),
    number("li_cation_fraction_low", decimals=5),
    number("li_cation_fraction_high", decimals=5),
    text("method"),
    text("flags"),
)
TABLES = {"files": FILES, "peaks": PEAKS, "elements": ELEMENTS, "plasma": PLASMA}

Cells = dict[str, Any]
"""The cells of one table by column: arrays or lists of one length; NaN and None are empty cells."""

BETWEEN_FLAGS = "; "
