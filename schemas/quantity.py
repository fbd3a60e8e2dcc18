"""Numbers with units: read from text, converted, and written as people write them.

A pint `Quantity` is what a protocol computes with; a driver gets bare numbers in its contract's
unit. pint is imported on first use, since its registry takes a third of a second.
"""

import re
import sys
from collections.abc import Collection
from functools import cache, lru_cache
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, TypeGuard
from unicodedata import normalize

from pydantic import AfterValidator

from ..system.start import without

if TYPE_CHECKING:
    from pint import Quantity, UnitRegistry

# Any letter behind a number begins a unit, if perhaps an unknown one; so do °, ℃, Å and ㎜.
_BEGINS = (
    "A-Za-z°º˚µ%‰\u00c0-\u00d6\u00d8-\u00f6\u00f8-\u024f\u0370-\u052f\u2100-\u214f\u3380-\u33df"
)
QUANTITY = re.compile(rf"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([{_BEGINS}].*?)\s*$")

KINDS = {
    "[length]": "a length",
    "[time]": "a time",
    "[mass]": "a mass",
    "[temperature]": "a temperature",
    "[length] ** 3": "a volume",
    "[length] ** 2": "an area",
    "[length] / [time]": "a speed",
    "[length] ** 3 / [time]": "a flow rate",
    "[mass] / [length] / [time] ** 2": "a pressure",
    "[length] / [time] ** 2": "an acceleration",
    "1 / [time]": "a rate",
    "[current]": "a current",
    "[current] * [time]": "a charge",
    "[mass] * [length] ** 2 / [time] ** 2": "an energy",
    "dimensionless": "a plain number",
}


SIZES = {
    "length": {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0},
    "time": {"us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0},
    "volume": {"uL": 1e-6, "µL": 1e-6, "mL": 1e-3, "L": 1.0},
    "mass": {"ug": 1e-6, "µg": 1e-6, "mg": 1e-3, "g": 1.0, "kg": 1e3},
}
"""The units that most protocols need, in one of their kind; a test holds them against pint."""
COMMON = (
    "degC", "K", "V", "mV", "kV", "A", "mA", "W", "mW", "Hz", "kHz", "MHz", "Pa", "kPa", "mbar", "bar",
    "torr", "ohm", "millimeter", "millimetre", "centimeter", "millisecond", "milliliter", "millilitre",
    "milligram", "celsius",
)  # fmt: skip
"""Others that are often written with the wrong capital letters, or a letter too few."""
GAS_FLOWS = ("sccm = cm**3 / min", "slm = L / min", "slpm = L / min")
"""As a volume at the standard conditions of whoever wrote it, which differ: 0, 15, 20 or 25 degC."""
PLAIN = {unit: (kind, size) for kind, sizes in SIZES.items() for unit, size in sizes.items()}
MEANT = {
    "gm": "g", "gr": "g", "Sec": "s", "mn": "min", "Kelvin": "K", "Celsius": "degC", "C": "degC", "F": "degF",
    "U/min": "rpm", "U / min": "rpm", "℃": "degC", "℉": "degF", "ºC": "degC", "˚C": "degC",
    "мкм": "µm", "мм": "mm", "см": "cm", "с": "s", "мин": "min", "ч": "h",
    "мкл": "µL", "мл": "mL", "мг": "mg", "г": "g",
}  # fmt: skip
"""Units as people write them whom pint does not understand, or takes for others: C for coulomb."""
WOULD_BE = {
    "gr": "a grain, 0.065 g", "MM": "a megamolar", "ML": "a megalitre", "PA": "a petaampere",
}  # fmt: skip
"""What nobody means."""
OFTEN_OF_HEAT = {"C": "a coulomb, a charge", "F": "a farad, a capacitance"}
"""What a temperature is written in by whom pint takes at his word."""
_HEAT = re.compile(
    r"(?<![a-z])temp(s|eratures?)?(?![a-z])|celsius|fahrenheit|°|heat|cool|chill|oven|furnace|thermo",
    re.I,
)
_NO_HEAT = re.compile(r"charg|capaci|coulomb|farad", re.I)
SIGNS = "°·×⋅•⁻⁺‰∞"
"""What pint reads besides letters and digits; all else it drops without a word."""
USUAL = str.maketrans({"∕": "/", "⁄": "/", "÷": "/", "−": "-", "–": "-", "˚": "°"})
TURNS = {"turn", "revolutions_per_minute", "revolutions_per_second", "degree"}


class UnitError(ValueError):
    """A unit that is unknown, or of a different dimension than the one required."""


@cache
def registry() -> "UnitRegistry":
    """The one unit registry of the process."""
    import logging  # pint does; what needs no pint needs none

    UnitRegistry = _pint().UnitRegistry  # noqa: N806

    try:
        made = UnitRegistry(cache_folder=":auto:", autoconvert_offset_to_baseunit=True)
    except Exception:  # no folder to keep it in, or one left incomplete by another process
        made = UnitRegistry(cache_folder=None, autoconvert_offset_to_baseunit=True)
    told = logging.getLogger("pint.util")
    level = told.level
    told.setLevel(logging.ERROR)  # it warns of a unit that is defined again
    for definition in (*GAS_FLOWS, "ppb = 1e-9", "liter = decimeter**3 = L = l = litre"):
        made.define(definition)
    told.setLevel(level)
    return made


def _pint() -> Any:
    """pint without numpy and dask, which it imports if installed: half of its time, for nothing.

    What has numpy already, as the Python face does, gets quantities that know arrays.
    """
    with_dask = "dask" in sys.modules
    try:
        if not with_dask:
            sys.modules["dask"] = None  # type: ignore[assignment]
        with without("numpy"):
            return import_module("pint")
    finally:
        if not with_dask:
            del sys.modules["dask"]


def is_quantity(value: object) -> "TypeGuard[Quantity[Any]]":
    """True for a pint quantity; costs no import when there is none yet."""
    return hasattr(value, "magnitude") and hasattr(value, "units")


def is_number(value: object) -> "TypeGuard[int | float]":
    """True for a number without a unit; `true` is none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


@lru_cache(maxsize=4096)
def unit_of(text: str, wanted: str | None = None) -> Any:
    """The pint unit that a text names; raises UnitError for an unknown one.

    The error proposes another unit, of the kind of `wanted` if that is given.
    """
    if re.search(r"[^\W\d_µμ][µμ]$", text):  # to pint `mµ` is a thousandth of a micron
        raise UnitError(f"{text!r} is not a unit; did you mean µ{text[:-1]}?")
    if text in WOULD_BE:
        raise UnitError(f"{text!r} would be {WOULD_BE[text]}{_did_you_mean(text, wanted)}")
    units = registry()
    if odd := next(
        (one for one in text if not _is_read(one)), ""
    ):  # pint drops it: `mg∕L` is mg * L
        guess = _did_you_mean(text, wanted) or _with_usual_signs(text)
        raise UnitError(f"{text!r} is not a unit{guess or f': it holds {odd} (U+{ord(odd):04X})'}")
    try:
        return units.Unit(text)
    except Exception as fault:  # pint raises half a dozen unrelated classes for a bad unit
        raise UnitError(f"{text!r} is not a unit{_did_you_mean(text, wanted)}") from fault


def _is_read(character: str) -> bool:
    """Whether pint makes something of a character in a unit."""
    return character.isascii() or character.isalnum() or character.isspace() or character in SIGNS


def _with_usual_signs(text: str) -> str:
    """`; did you mean mg/L?` of `mg∕L`, if that is a unit."""
    usual = normalize("NFKC", text).translate(USUAL)
    try:
        return f"; did you mean {usual}?" if usual != text and unit_of(usual) else ""
    except UnitError:
        return ""


def unit_fault(unit: str, about: str, beside: Collection[str] = ()) -> str:
    """What is wrong in the unit that a value is said to have; empty if nothing is.

    `about`: its name and whatever is said of it; `beside`: the units of other values. Both tell whether C
    is meant for a coulomb.
    """
    try:
        unit_of(unit)
    except UnitError as fault:
        return str(fault)
    if unit not in OFTEN_OF_HEAT or _NO_HEAT.search(about):
        return ""
    words, meant = OFTEN_OF_HEAT[unit], MEANT[unit]
    if not (_HEAT.search(about) or any(one in ("degC", "degF", "°C", "°F") for one in beside)):
        return ""
    written_out = words.split()[1].rstrip(",")
    return f"{unit!r} would be {words}; did you mean {meant}? Write {written_out} if it is one"


def _did_you_mean(text: str, wanted: str | None = None) -> str:
    """`; did you mean mm?`: the unit that is written almost like this, of the kind that is wanted."""
    known = [wanted] if wanted else []
    for unit in (MEANT.get(text), *known, *PLAIN, *COMMON):
        if unit is None or unit == text or not (unit is MEANT.get(text) or _almost(text, unit)):
            continue
        if wanted is None or same_dimension(unit, wanted):
            return f"; did you mean {unit}?"
    return ""


def _almost(text: str, unit: str) -> bool:
    """Whether they differ by capital letters, by one letter that comes twice, or by a dot."""
    plain, other = normalize("NFKC", text).casefold().rstrip("."), unit.casefold()  # of ㎜, too
    return plain == other or re.sub(r"(.)\1+", r"\1", plain) == re.sub(r"(.)\1+", r"\1", other)


def quantity(magnitude: float, unit: str) -> "Quantity[Any]":
    """A number with its unit."""
    made: Any = registry().Quantity(magnitude, unit_of(unit))
    return made


@lru_cache(maxsize=4096)
def parse_quantity(text: str, wanted: str | None = None) -> "Quantity[Any]":
    """`0.2 mm` as a quantity; raises UnitError if the text is not one, see `unit_of`."""
    match = QUANTITY.match(text)
    if match is None:
        comma = re.fullmatch(r"([-+]?\d+),((?!\d{3}\b)\d+.*)", text)  # of `1,000` who knows
        such = f"{comma[1]}.{comma[2]}" if comma else "0.2 mm"
        raise UnitError(f"{text!r} is not a number with a unit, such as `{such}`")
    number = match[1]
    value = int(number) if re.fullmatch(r"[+-]?\d+", number) else float(number)
    made: Any = registry().Quantity(value, unit_of(match[2], wanted))
    return made


@lru_cache(maxsize=4096)
def kind_of_unit(unit: str) -> str:
    """What a unit measures, in words: `a length`, `a time`."""
    if unit in PLAIN:
        return f"a {PLAIN[unit][0]}"
    dimensionality = unit_of(unit).dimensionality
    for key, words in KINDS.items():
        if dimensionality == _dimensions(key):
            return words
    return f"a quantity in {unit}"


@cache
def _dimensions(key: str) -> Any:
    return (
        registry().get_dimensionality(key) if key != "dimensionless" else unit_of("").dimensionality
    )


@lru_cache(maxsize=4096)
def _factor(source: Any, target: str) -> float | None:
    """The number to multiply by, or None if the conversion is not a plain factor (degC, dBm)."""
    one = registry().Quantity(1.0, source)
    plain = one._is_multiplicative and not has_offset(target)
    return float(one.to(target).magnitude) if plain else None


def same_dimension(unit: str, other: str) -> bool:
    """True when one of the units can be converted into the other."""
    if unit in PLAIN and other in PLAIN and PLAIN[unit][0] == PLAIN[other][0]:
        return True
    return unit_of(unit).dimensionality == unit_of(other).dimensionality


@lru_cache(maxsize=4096)
def has_offset(unit: str) -> bool:
    """True for a scale whose zero is not nothing: degC, degF and dBm, not K."""
    return not registry().Quantity(1, unit_of(unit))._is_multiplicative


@lru_cache(maxsize=4096)
def degree(unit: str) -> Any:
    """One degree of a temperature scale, as the unit of differences on it."""
    return unit_of(f"delta_{unit_of(unit)}" if has_offset(unit) else unit)


@lru_cache(maxsize=4096)
def converts(source: Any, unit: str) -> bool:
    """True when a quantity with these units can be converted into the unit."""
    return source.is_compatible_with(unit_of(unit))


@lru_cache(maxsize=4096)
def cancels_out(units: Any) -> bool:
    """True if the units cancel out: mm/um, not degrees."""
    return registry().get_root_units(units)[1] == unit_of("")


def magnitude_in(value: Any, unit: str) -> float:
    """The number of a quantity, a text such as `0.2 mm`, or a bare number, in `unit`.

    Raises UnitError, with both dimensions in words, if the dimensions differ.
    """
    if isinstance(value, str):
        if (number := plainly(value, unit)) is not None:
            return number
        value = parse_quantity(value, unit)
    if not is_quantity(value):
        return value  # a bare number is in the contract's unit
    if not converts(value.units, unit):
        raise UnitError(
            f"{quantity_text(value)} is {kind_of_unit(str(value.units))}, "
            f"wanted is {kind_of_unit(unit)} ({unit}){unit_meant(value, unit)}"
        )
    _refuse_turns(value.units, unit)
    if value.units == unit_of(unit):
        return value.magnitude
    factor = _factor(value.units, unit)
    if factor is None:
        if value.magnitude <= 0 and any(
            registry()._units[n].is_logarithmic for n in unit_of(unit)._units
        ):
            raise UnitError(f"{quantity_text(value)} has no logarithm, so it is nothing in {unit}")
        return float(value.to(unit).magnitude)
    # 0.1 + 0.2 style digits behind the 12th come from the factor, not from the author.
    return float(f"{value.magnitude * factor:.12g}")


def capital_slip(text: Any, unit: str) -> str:
    """What is likely wrong in `5 MW` where mW is the unit: a prefix in the other case; else empty."""
    match = QUANTITY.match(text) if isinstance(text, str) else None
    if match is None or match[2] == unit or match[2].casefold() != unit.casefold():
        return ""
    try:
        one, value = magnitude_in(f"1 {match[2]}", unit), magnitude_in(text, unit)
    except UnitError:
        return ""
    return (
        "" if one == 1 else f"{text.strip()} is {number_text(value)} {unit}; did you mean {unit}?"
    )


def unit_meant(value: "Quantity[Any]", unit: str) -> str:
    """`; did you mean mm?` of a quantity of another kind than the unit; nothing where no slip explains it."""
    return _did_you_mean(f"{value.units:~}".removesuffix(" * deg"), unit)  # of `deg C`, too


@lru_cache(maxsize=4096)
def _refuse_turns(source: Any, unit: str) -> None:
    """Raise UnitError between turns and Hz: to pint a turn is 6.28, so 60 rpm would be 6.28 Hz."""
    wanted = unit_of(unit)
    own, other = ({str(part) for part in units._units} for units in (source, wanted))
    if bool(own & TURNS) != bool(other & TURNS) and "radian" not in own | other:
        raise UnitError(
            f"{source:~P} and {unit} do not say whether a turn or a radian is meant; write {wanted:~P}"
        )


@lru_cache(maxsize=4096)
def plainly(text: str, unit: str) -> float | None:
    """The number of `0.2 mm` in `unit` where that needs no pint, which takes long to import; else None."""
    match = QUANTITY.match(text)
    if match is None:
        return None
    number, own, wanted = match[1], PLAIN.get(match[2]), PLAIN.get(unit)
    if own is None or wanted is None or own[0] != wanted[0]:
        return None
    if own == wanted:
        return int(number) if re.fullmatch(r"[+-]?\d+", number) else float(number)
    return float(f"{float(number) * (own[1] / wanted[1]):.12g}")


def seconds(value: Any) -> float:
    """A duration in seconds: `30 s`, `2 min`, a quantity, or a bare number of seconds."""
    return float(magnitude_in(value, "s"))


def _is_a_time(value: int | float | str) -> int | float | str:
    try:
        if seconds(value) > 0:
            return value
    except UnitError:
        pass  # what it is not is said below, with what it should be
    raise ValueError(f"{value!r} is not a time longer than 0 s, such as `60 s`")


Duration = Annotated[int | float | str, AfterValidator(_is_a_time)]
"""A time longer than 0 s as a person writes it, for a model's field."""
DurationText = Annotated[str, AfterValidator(_is_a_time)]
"""The same, as text only."""


def number_text(value: float) -> str:
    """A number without the noise of binary fractions: `0.2`, not `0.20000000000000001`."""
    return f"{value:.12g}"


def quantity_text(value: "Quantity[Any]") -> str:
    """`0.2 mm`: as people write it."""
    unit = f"{value.units:~P}"
    return f"{number_text(value.magnitude)} {unit}".rstrip()
