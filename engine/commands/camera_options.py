"""Options that the commands about cameras share, and how their values are read."""

import re

from ...schemas.quantity import UnitError, magnitude_in, parse_quantity
from ...system.extras import missing
from .options import fail

BOARD = re.compile(r"(\d{1,2}) ?[xX×] ?(\d{1,2})")


def needs_vision() -> None:
    """End the command with the line that adds what it works with, if that is not installed."""
    if (why := missing("vision")) is not None:
        fail(why)


def board_size(text: str) -> tuple[int, int]:
    """`9x6` as columns and rows of inner corners; any other form ends the command."""
    found = BOARD.fullmatch(text.strip())
    columns, rows = (int(part) for part in found.groups()) if found else (0, 0)
    if not (3 <= columns <= 30 and 3 <= rows <= 30):
        fail(f"--board {text}: write columns x rows of inner corners, 3 to 30 each: --board 9x6")
    return columns, rows


def length_mm(text: str, option: str, *, above_zero: bool = False) -> float:
    """`25 mm` or a plain number of millimetres; anything else ends the command."""
    try:
        value = float(text)
    except ValueError:
        try:
            value = float(magnitude_in(parse_quantity(text), "mm"))
        except (UnitError, ValueError) as fault:
            fail(f'{option} {text}: {fault}; write a length: {option} "25 mm"')
    if value != value or abs(value) > 1e6 or (above_zero and value <= 0):
        fail(f'{option} {text}: write a length{" above 0" if above_zero else ""}: {option} "25 mm"')
    return value


def pair_of_numbers(text: str, option: str, unit: str | None = None) -> tuple[float, float]:
    """`640,360` as two numbers; with a unit also `100 mm,300 mm`."""
    parts = text.split(",")
    if len(parts) == 2 and unit is not None:
        return length_mm(parts[0].strip(), option), length_mm(parts[1].strip(), option)
    try:
        first, second = map(float, parts)
    except ValueError:
        first = second = float("inf")
    if not (abs(first) < 1e6 and abs(second) < 1e6):
        fail(f"{option} {text}: write two numbers separated by a comma: {option} 640,360")
    return first, second
