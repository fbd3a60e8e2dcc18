"""Texts that instruments answer, as values of a JSON Schema: numbers with or without their unit.

SCPI (volume 1, 7.2.1) writes infinity as 9.9E37 and not-a-number as 9.91E37.
"""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from ...schemas.contract import Happened
from ...schemas.quantity import UnitError, kind_of_unit, magnitude_in, quantity, registry, unit_of
from .number_forms import FORMS, decimals

NUMBER = re.compile(
    r"\s*([+-]?\s*(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?|ovld|overload|overflow|ovrflw|overrange|over|ovl|ovf|o\.?l|underflow|underrange|under))"
    r"\s*([A-Za-z%°µμΩ][^,;]*)?\s*",
    re.I,
)
INFINITE = 9.9e37
NOT_A_NUMBER = 9.91e37
BEYOND = (
    "ovld", "overload", "overflow", "ovrflw", "overrange", "over", "ovl", "ovf", "ol", "o.l",
    "underflow", "underrange", "under",
)  # fmt: skip
WORDS: dict[str, float] = dict.fromkeys(BEYOND, math.inf)
DASHES = re.compile(r"[-*?]{2,}|\.{2,}$|n/?a$", re.I)
"""What a display shows that has no reading."""
UNITS = {
    "vdc": "V", "vac": "V", "adc": "A", "aac": "A", "ohms": "ohm", "ohm4w": "ohm", "ohms4w": "ohm",
    "secs": "s", "sec": "s", "deg c": "degC", "deg f": "degF", "°c": "degC", "°f": "degF",
    "c": "degC", "f": "degF", "celsius": "degC", "oc": "degC", "kohm": "kohm", "lpm": "L/min",
    "cel": "degC", "volts": "V", "amps": "A", "%rh": "%", "nm": "N*m", "cts": "count", "g": "gauss",
}  # fmt: skip
"""What instruments write -> the unit, where pint does not know it or knows another one."""
MEGA = {"MHZ": "MHz", "MOHM": "megaohm", "MOHMS": "megaohm"}
"""In capitals M is milli or mega; of these SCPI (volume 1, 7.1) says that it is mega."""
HUGE = ("peta", "exa", "zetta", "yotta", "ronna", "quetta")
POWER = re.compile(r"(?<=[A-Za-zµμ])(?=-?\d)")
DIGITS = re.compile(r"[+-]?\d{1,30}")
UNIT = re.compile(r"[\w%°µμΩ/*^·() +.-]+")
"""What a unit is written with: a mark behind it says something else, that a balance does not stand still."""
NUMBER_ERRORS: dict[str, tuple[Happened, str]] = {
    "BadAnswer": ("unknown", "The answer is not what this action returns"),
    "Overload": ("yes", "The instrument answered that the value is beyond its range"),
    "NotANumber": ("yes", "The instrument answered that it has no value"),
}
OWN = ("scale", "offset", "base", "bit", "bits", "words", "power", "decimal", "nothing", *FORMS)
"""How a value is written, as a lab says it: value = what is written × scale + offset."""
TRUE, FALSE = {"1", "on", "true", "yes"}, {"0", "off", "false", "no"}


FIELD = re.compile(r"""(?:^|[,;\n])(\s*(?:"(?:[^"]|"")*"|'[^']*')\s*(?=[,;\n]|$)|[^,;\n]*)""")
"""One of several values; a comma within quotes is part of a text."""
BASE = re.compile(r"#[hqb]|0[xob]|\$|h$", re.I)
"""What stands before or behind a number that is not decimal."""
NUMERAL = re.compile(r"#h[0-9a-f]+|#q[0-7]+|#b[01]+|0x[0-9a-f]+", re.I)
BASES = {"h": 16, "x": 16, "q": 8, "b": 2}
"""How SCPI (IEEE 488.2, 8.7.3) and C write it."""


class BadAnswer(ValueError):
    """An answer that is not what the contract returns, with the reason."""


class NoNumber(ValueError):
    """The instrument answered that it has no number: `name` is the contract's error."""

    def __init__(self, name: str, words: str) -> None:
        super().__init__(words)
        self.name = name


PART = "; only a part of it does, and the whole has to: write `.*` where more may stand"


def unmatched(text: str, pattern: Any) -> BadAnswer:
    """That an answer is not the one that was wanted, or has more in it."""
    part = PART if pattern.search(text) else ""
    return BadAnswer(f"it does not match {pattern.pattern!r}{part}")


def values(
    text: str, returns: Mapping[str, Any], pattern: Any, decimal: str = "."
) -> dict[str, Any]:
    """The values of an answer; raises BadAnswer or NoNumber.

    With a pattern: its named groups, or its groups in order. Without: fields between commas or
    semicolons; an array takes what is left. A decimal comma stands between two digits. Where all are
    bits, of one number, each is read from it.
    """
    pointed = str if decimal == "." else _pointed
    if pattern is None:
        return _split(pointed(text), returns)
    found = pattern.fullmatch(text) or pattern.fullmatch(text.strip())
    table = returns and all(_kind(schema) == "array" for schema in returns.values())
    if table and (len(returns) > 1 or (found is None and "\n" in text)):
        return _columns([_parts(line, returns, pattern) for line in text.splitlines()], returns)
    if found is None:
        raise unmatched(text, pattern)
    if not returns:
        return {}

    def read(part: str, schema: Mapping[str, Any]) -> Any:
        return value(pointed(part), schema)

    named = found.groupdict()
    if named:
        missing = [name for name in returns if named.get(name) is None]
        if missing and not may_lack(returns[missing[0]]):
            raise BadAnswer(f"{missing[0]} is not in it")
        return {n: None if named.get(n) is None else read(named[n], s) for n, s in returns.items()}
    parts = [part for part in found.groups() if part is not None] or [found[0]]
    parts = _for_each_bit(parts, returns)
    if len(parts) < len(returns):
        raise BadAnswer(f"it has {len(parts)} of {len(returns)} values")
    return {name: read(part, schema) for (name, schema), part in zip(returns.items(), parts)}  # noqa: B905


def _pointed(text: str) -> str:
    return re.sub(r"(?<=\d),(?=\d)", ".", text)


def _split(text: str, returns: Mapping[str, Any]) -> dict[str, Any]:
    if len(returns) <= 1:
        return {name: value(text, schema) for name, schema in returns.items()}
    if all(_kind(schema) == "array" for schema in returns.values()) and "\n" in text:
        rows = [_fields(line) for line in text.splitlines()]
        return _columns([row if row[1:] else row[0].split() for row in rows if row], returns)
    left = _fields(text)
    if len(left) == 1 and len(blank := text.split()) == len(returns):
        left = blank
    left = _for_each_bit(left, returns)
    found, told = {}, len(left)
    for name, schema in returns.items():
        if not left:
            raise BadAnswer(f"it has no {name}")
        if _kind(schema) == "array":
            found[name], left = value(",".join(left), schema), []
        else:
            found[name] = value(left.pop(0), schema)
    if left:
        raise BadAnswer(_too_many(told, returns, decimal_comma=";" in text and "," in text))
    return found


def _for_each_bit(parts: list[str], returns: Mapping[str, Any]) -> list[str]:
    """A single number once for each result, if all of these are bits of it."""
    bits = len(parts) == 1 and all({"bit", "bits"} & set(one) for one in returns.values())
    return parts * len(returns) if bits else parts


def _fields(text: str) -> list[str]:
    """What stands between commas or semicolons; one behind the last value is no value more."""
    found: list[str] = FIELD.findall(text)
    return found[: -1 if not found[-1].strip() else None]


def _too_many(told: int, returns: Mapping[str, Any], *, decimal_comma: bool) -> str:
    hint = 'a decimal comma? Then say `decimal: ","`' if decimal_comma else "an `answer` picks them"
    return f"it has {told} values, and {len(returns)} are wanted; {hint}"


def _columns(rows: list[list[str]], returns: Mapping[str, Any]) -> dict[str, Any]:
    """A table, a line of the answer for each row: each column is an array."""
    if short := next((row for row in rows if len(row) < len(returns)), None):
        raise BadAnswer(f"the row {short} has {len(short)} of {len(returns)} values")
    if long := next((row for row in rows if len(row) > len(returns)), None):
        words = _too_many(len(long), returns, decimal_comma=False)
        raise BadAnswer(f"of the row {long}: {words}")
    items = [items_of(schema) for schema in returns.values()]
    columns = [[value(row[at], one) for row in rows] for at, one in enumerate(items)]
    return dict(zip(returns, columns, strict=True))


def _array(fields: list[str], one: Mapping[str, Any]) -> list[Any]:
    """The values of an array; within a field they may stand between blanks, but `1.2 V` is one."""
    whole = len(fields) > 1 and _kind(one) == "string"
    parts = (
        [field] if whole or NUMBER.fullmatch(field) else field.split() or [""] for field in fields
    )
    return [value(part, one) for several in parts for part in several]


def items_of(schema: Mapping[str, Any]) -> dict[str, Any]:
    """One of an array's values; how it is written stands beside the array."""
    own = {key: schema[key] for key in OWN if key in schema}
    return {**schema.get("items", {"type": "number"}), **own}


def _parts(line: str, returns: Mapping[str, Any], pattern: Any) -> list[str]:
    found = pattern.fullmatch(line.strip())
    if found is None:
        raise BadAnswer(f"its line {line[:80]!r} does not match {pattern.pattern!r}")
    named = found.groupdict()
    return [named.get(name) or "" for name in returns] if named else list(found.groups())


def value(text: str, schema: Mapping[str, Any]) -> Any:
    """One value; raises BadAnswer or NoNumber."""
    if set(FORMS) & set(schema):
        return _formed_value(text, schema)
    if schema.get("decimal") == ",":
        text = _pointed(text)
    plain, kind = text.strip(), _kind(schema)
    if kind == "array":
        return _array(_fields(plain), items_of(schema))
    bare = plain.strip("\"'").lower()
    if any(
        isinstance(one, str) and one.strip().lower() == bare for one in schema.get("nothing", ())
    ):
        return none_for("NotANumber", f"it answered {plain!r}, which is no value", schema)
    if which := schema.get("bits") or ([schema["bit"]] * 2 if "bit" in schema else None):
        rest = {key: one for key, one in schema.items() if key not in ("bit", "bits", "base")}
        kind = {"type": "boolean"} if "bit" in schema else {}
        return value(str(some_bits(_whole(plain, schema), which)), {**kind, **rest})
    if "words" in schema:
        for word, written in words_of(schema).items():
            if bare == str(written).strip().lower():
                return word
        raise BadAnswer(f"{plain!r} is none of {', '.join(map(str, schema['words'].values()))}")
    if kind in ("number", "integer"):
        return _number(plain, schema, whole=kind == "integer")
    if kind == "boolean":
        if bare not in TRUE | FALSE:
            raise BadAnswer(f"{plain!r} is neither on nor off")
        return bare in TRUE
    quoted = len(plain) > 1 and plain[0] == plain[-1] and plain[0] in "\"'"
    return plain[1:-1].replace(plain[0] * 2, plain[0]) if quoted else plain


def _formed_value(text: str, schema: Mapping[str, Any]) -> Any:
    """As if the instrument had written the number in decimal."""
    try:
        numbers = decimals(text, schema)
    except ValueError as fault:
        raise BadAnswer(str(fault)) from fault
    if len(numbers) > 1 and _kind(schema) != "array":
        raise BadAnswer(f"{len(text)} bytes are {len(numbers)} numbers of {schema['bytes']}")
    decimal = {key: value for key, value in schema.items() if key not in ("base", *FORMS)}
    if _kind(schema) == "boolean" and not {"bit", "words"} & set(schema):
        return float(numbers[0]) != 0
    return value(",".join(numbers), decimal)


def _number(text: str, schema: Mapping[str, Any], *, whole: bool) -> float | int | None:
    if "base" in schema or NUMERAL.fullmatch(text):
        return _meant(_whole(text, schema), schema, whole=whole)
    found = NUMBER.fullmatch(text)
    if DASHES.match(text):
        return none_for("NotANumber", f"it answered {text!r}: it has no number", schema)
    if found is None:
        comma = NUMBER.fullmatch(_pointed(text)) and (
            '; a decimal comma? Then say `decimal: ","`; two values? Then each is a group, `([^,]*)`'
        )
        other = "; the group of an `answer: '...(.*)'` picks the part that is"
        if text and not re.search(r"\d", text):
            other = f"; if it stands for none, say `nothing: [{text!r}]`"
        raise BadAnswer(f"{text!r} is not a number{comma or (other if text else '')}")
    word = found[1].replace(" ", "")
    size = WORDS.get(word.lstrip("+-").lower())
    number = float(re.sub("[dD]", "e", word)) if size is None and word[-1:].isdigit() else size
    number = float(word) if number is None else number
    if whole and DIGITS.fullmatch(word):
        number = int(word)  # a serial number or a time in ns has more digits than a float
    size = abs(number)
    if math.isnan(number) or math.isclose(size, NOT_A_NUMBER, rel_tol=1e-6):
        return none_for("NotANumber", f"it answered {text!r}: it has no number", schema)
    if size >= INFINITE * (1 - 1e-6):
        return none_for("Overload", f"it answered {text!r}: beyond its range", schema)
    if found[2] and schema.get("unit"):
        number = _in_unit(number, found[2].strip(), schema["unit"])
    elif found[2]:
        raise BadAnswer(
            f"{text!r} has a unit, and the contract has none; an `answer: '(.*) {found[2].strip()}'` picks "
            f"the number"
        )
    if whole and number != int(number):
        raise BadAnswer(f"{text!r} is not a whole number")
    return _meant(number, schema, whole=whole)


def _whole(text: str, schema: Mapping[str, Any]) -> int:
    """A whole number in the base that the lab says, decimal unless it does."""
    try:
        base = BASES.get(text[1:2].lower(), 10) if NUMERAL.fullmatch(text) else 10
        return int(BASE.sub("", text.strip()), int(schema.get("base", base)))
    except ValueError:
        raise BadAnswer(f"{text!r} is no number of base {schema.get('base', 10)}") from None


def some_bits(number: int, which: Sequence[int]) -> int:
    """The number that some bits of it are, from the lowest to the highest of `which`."""
    return number >> which[0] & (1 << which[1] - which[0] + 1) - 1


def _meant(number: float, schema: Mapping[str, Any], *, whole: bool) -> float | int | None:
    """What a number that was written stands for; some stand for none."""
    if number in schema.get("nothing", ()):
        return none_for("NotANumber", f"it answered {number:g}, which is no value", schema)
    scale, offset = schema.get("scale", 1), schema.get("offset", 0)
    if (scale, offset) != (1, 0):
        number = float(f"{number * scale + offset:.12g}")
    return whole_of(number) if whole else float(number)


def whole_of(number: float) -> int:
    """A number without a fraction; raises BadAnswer, since to leave it out would be another value."""
    if number != int(number):
        raise BadAnswer(f"{number:.12g} is not a whole number")
    return int(number)


def words_of(schema: Mapping[str, Any]) -> dict[Any, Any]:
    """Value -> what the instrument writes; YAML's keys are texts, whatever they stand for."""
    kind = schema.get("type") or ("number" if "unit" in schema else "string")
    if kind in ("number", "integer"):
        read: Any = float if kind == "number" else int
        return {read(key): written for key, written in schema["words"].items()}
    known = {"true": True, "false": False}
    return {known.get(str(key).lower(), key): one for key, one in schema["words"].items()}


def none_for(name: str, words: str, schema: Mapping[str, Any]) -> None:
    """Null where the contract allows it; otherwise raises NoNumber."""
    if not may_lack(schema):
        raise NoNumber(name, words)


def _in_unit(number: float, written: str, unit: str) -> float:
    picks = f"an `answer: '(.*) {written}'` picks the number"
    if not UNIT.fullmatch(written):
        raise BadAnswer(f"{written!r}, which stands behind the number, is no unit; {picks}")
    if written.isupper() and written.lower() == unit.lower():
        return number  # in capitals, as some write all that they say
    written = MEGA.get(written, written)
    if written.isascii() and written.isupper() and written[0] == "M":
        sizes = [name for name in _any_case(written) if _fits(name, unit)]
        if {name[:4] for name in sizes} >= {"mill", "mega"}:
            raise BadAnswer(f"{written} may be {' or '.join(sorted(sizes))}; {picks}")
    powers = POWER.sub("^", written)  # cm-1, m3/h
    for name in dict.fromkeys((written, UNITS.get(written.lower(), written), powers)):
        if not _is_huge(name) and _fits(name, unit):
            return _magnitude(number, name, unit)
    if written.islower() and written == unit.lower():
        return number
    fitting = [name for name in _any_case(written) if _fits(name, unit)]  # KHZ, KV: as IEEE 488.2
    if len({_magnitude(1.0, name, unit) for name in fitting}) > 1:
        raise BadAnswer(f"{written} may be {' or '.join(sorted(fitting))}; {picks}")
    if not fitting:
        raise BadAnswer(f"its unit is {written!r}, wanted is {kind_of_unit(unit)} ({unit})")
    return _magnitude(number, fitting[0], unit)


def _magnitude(number: float, written: str, unit: str) -> float:
    try:
        return magnitude_in(quantity(number, written), unit)
    except UnitError as fault:  # turns and radians in a second
        raise BadAnswer(str(fault)) from fault


def _any_case(written: str) -> list[str]:
    first, rest = written[0], written[1:]
    other = first.upper() if written.islower() else first.lower()
    ways = dict.fromkeys((written, other + rest))
    found = [registry().parse_unit_name(way, case_sensitive=False) for way in ways]
    return ["".join(parts[:2]) for one in found for parts in one if parts[0] not in HUGE]


def _is_huge(written: str) -> bool:
    """Whether it can only be read as 10^15 or more of something: PA is no petaampere."""
    prefixes = [parts[0] for parts in registry().parse_unit_name(written)]
    return bool(prefixes) and all(prefix in HUGE for prefix in prefixes)


def _fits(name: str, unit: str) -> bool:
    try:
        return unit_of(name).dimensionality == unit_of(unit).dimensionality
    except UnitError:
        return False


def _kind(schema: Mapping[str, Any]) -> str:
    from .config import typed

    kind = typed(dict(schema))["type"]
    return next((one for one in kind if one != "null"), "null") if isinstance(kind, list) else kind


def may_lack(schema: Mapping[str, Any]) -> bool:
    """Whether the contract allows null."""
    kind = schema.get("type", "")
    return isinstance(kind, list) and "null" in kind
