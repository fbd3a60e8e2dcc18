"""What somebody looks for among runs: `core sample:core-17 pitch<0.2mm since:2026-11-01 -tag:bad`.

Words are looked for in all text of a run. `KEY:TEXT` looks in one thing, `NAME=VALUE` (also with
`>`, `<`, `>=`, `<=`, `!=`) compares a parameter or a number that the run came to, with units. All
terms have to hold; one with a `-` before it must not. Quotes keep words together.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta
from math import isfinite, nan
from typing import Any

from ...schemas.quantity import UnitError, is_number, magnitude_in
from ..journal.encode import QUANTITY_KEY
from ..language.suggest import did_you_mean
from ..run.came_to import value_text

TEXTS = {
    "sample": "samples", "device": "devices", "person": "person", "tag": "tags", "note": "note",
    "outcome": "word", "protocol": "protocol", "reason": "reason", "run": "run",
}  # fmt: skip
"""Key -> the column that it looks in."""
DAYS = ("on", "since", "until")
TERM = re.compile(r'(?:[^\s"]|"[^"]*")+')
KEY = re.compile(r"(-?)([A-Za-z]+):(.*)", re.S)
COMPARED = re.compile(r"(-?)([A-Za-z_][\w.\-]*?)(>=|<=|!=|=|>|<)(.+)", re.S)
DAY = {"today": 0, "yesterday": 1}
OPERATORS: dict[str, Callable[[Any, Any], bool]] = {
    "=": lambda a, b: a == b, "!=": lambda a, b: a != b, ">": lambda a, b: a > b,
    "<": lambda a, b: a < b, ">=": lambda a, b: a >= b, "<=": lambda a, b: a <= b,
}  # fmt: skip
CLOSE = 1e-9
"""Numbers that differ by less, relatively, are equal: 0.2 mm is 200 µm."""
RULE = (
    "Words are looked for everywhere; sample: device: person: tag: note: outcome: protocol: reason: "
    "run: in one thing; on: since: until: take a day (2026-11-21, today, yesterday, 7d); "
    "pitch<0.2mm compares a parameter or a result"
)


class NotUnderstood(ValueError):
    """A search that means nothing; the text says which part, and what there is."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """A search as SQL: `where` with its `values`; `compared` are told by the function of that name."""

    where: str
    values: list[str]


def wanted(text: str, today: date | None = None) -> Wanted:
    """Read a search; raises NotUnderstood. Days are those of this machine's clock."""
    if text.count('"') % 2:
        raise NotUnderstood(f'{text}: a " is missing')
    terms = [term.replace('"', "") for term in TERM.findall(text)]
    found = [_term(term, today or date.today()) for term in terms]
    where = " AND ".join(f"({one.where})" for one in found) or "1"
    return Wanted(where, [value for one in found for value in one.values])


def _term(term: str, today: date) -> Wanted:
    if (found := KEY.fullmatch(term)) and not found[3].startswith("//"):
        no, key, value = found[1], found[2].lower(), found[3]
        made = _of_key(key, value, term, today)
    elif found := COMPARED.fullmatch(term):
        no, made = found[1], Wanted('compared(params, "values", ?, ?, ?)', [*found.groups()[1:]])
    else:
        no = "-" if term.startswith("-") and len(term) > 1 else ""
        made = Wanted("instr(words, ?) > 0", [term.removeprefix(no).lower()])
    return Wanted(f"NOT ({made.where})", made.values) if no else made


def _of_key(key: str, value: str, term: str, today: date) -> Wanted:
    if key in TEXTS:
        if not value:
            return Wanted(f"{TEXTS[key]} != ''", [])
        return Wanted(f"instr(lower({TEXTS[key]}), ?) > 0", [value.lower()])
    if key not in DAYS:
        raise NotUnderstood(
            f"{term}: there is no {key}:{did_you_mean(key, [*TEXTS, *DAYS])}. {RULE}"
        )
    begin = _day(value, term, today)
    first, last = _utc(begin), _utc(begin + timedelta(days=1))
    if key == "on":
        return Wanted("began >= ? AND began < ?", [first, last])
    return Wanted("began >= ?", [first]) if key == "since" else Wanted("began < ?", [last])


def _day(text: str, term: str, today: date) -> date:
    if text.lower() in DAY:
        return today - timedelta(days=DAY[text.lower()])
    try:
        if text.endswith("d") and text[:-1].isdecimal():
            return today - timedelta(days=int(text[:-1]))
        return date.fromisoformat(text)
    except (ValueError, OverflowError):
        raise NotUnderstood(f"{term}: write a day as 2026-11-21, today, yesterday or 7d") from None


def _utc(day: date) -> str:
    """When a day begins here, as the journal writes times."""
    try:
        return datetime.combine(day, time()).astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%S")
    except (OverflowError, OSError, ValueError):  # at the ends of what clocks can say
        return day.isoformat()


def compared(
    params: dict[str, Any], numbers: dict[str, Any], name: str, sign: str, text: str
) -> bool:
    """Whether a parameter or number of this name stands so to a value; False where there is none."""
    ours = [value for key, value in params.items() if key == name]
    ours += [
        {QUANTITY_KEY: told} if told[1] else told[0]
        for key, told in numbers.items()
        if name in (key, key.partition(".")[2])
    ]
    return any(_holds(one, sign, text) for one in ours)


def _holds(ours: Any, sign: str, text: str) -> bool:
    unit = ""
    if isinstance(ours, dict) and QUANTITY_KEY in ours:
        ours, unit = ours[QUANTITY_KEY]
    theirs = number_in(text, unit)
    if theirs is None or not is_number(ours):
        same = text.lower() in (value_text(ours).lower(), str(ours).lower())
        return {"=": same, "!=": not same}.get(sign, False)
    close = abs(ours - theirs) <= CLOSE * max(abs(ours), abs(theirs))
    return OPERATORS[sign](0.0 if close else ours - theirs, 0.0)


def number_in(text: str, unit: str) -> float | None:
    """The number that is written, in a unit; None where it is none, or of another dimension."""
    try:
        number = float(text)
    except ValueError:
        try:
            number = float(magnitude_in(text, unit)) if unit else nan
        except UnitError:
            return None
    return number if isfinite(number) else None
