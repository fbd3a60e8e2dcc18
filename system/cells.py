"""Text in the cells of a CSV file that a spreadsheet must not take for a formula.

A cell such as `=cmd|' /C calc'!A0` is executed by a spreadsheet that opens the file. With a `'`
before it, it is text there; our own readers take the `'` off again. Numbers stay as they are,
negative ones, too.
"""

import re

FORMULA = re.compile(r"'*[=+\-@\t\r]")
HARMLESS = re.compile(r"[-+0-9.,:eE ]*")
"""Numbers, and keys made of them, such as `-4,1`."""


def guarded(text: str) -> str:
    """The text as it is written into a cell."""
    return f"'{text}" if FORMULA.match(text) and not HARMLESS.fullmatch(text) else text


def bare(cell: str) -> str:
    """The text that a cell was written from."""
    return cell[1:] if cell.startswith("'") and guarded(cell[1:]) == cell else cell
