"""The actions of a Modbus device, from the table of registers in its manual, as a CSV file.

Columns: name, table (holding, input, coil, discrete) and address; where they are, type, scale, offset,
length, bit, word_order, unit, minimum, maximum, access (r, rw or w) and summary.
"""

import csv
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ....drivers.bridges.modbus_config import TABLES, Register
from ....schemas.model import first_fault
from ..protocol import CannotMake
from .metadata import Schema, unit
from .names import snake
from .sources import Described

NUMBERS = ("scale", "offset", "minimum", "maximum")
WHOLE = ("length", "bit")
KNOWN = {
    "name",
    "table",
    "address",
    "type",
    *NUMBERS,
    *WHOLE,
    "word_order",
    "unit",
    "access",
    "summary",
}


def describe(source: str) -> Described:
    """The device of `modbus:registers.csv`; raises CannotMake."""
    path = Path(source.partition(":")[2])
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as fault:
        raise CannotMake(f"{path} cannot be read: {fault}") from fault
    sign = max(",;\t", key=lines[0].count) if lines else ","
    rows = list(csv.DictReader(lines, delimiter=sign))
    columns = [str(one).strip().lower() for one in (rows[0] if rows else {})]
    lacking = [one for one in ("name", "table", "address") if one not in columns]
    unknown = [one for one in columns if one not in KNOWN]
    if lacking or unknown:
        what = f"no column {lacking[0]!r}" if lacking else f"an unknown column {unknown[0]!r}"
        raise CannotMake(f"{path} has {what}; its columns may be {', '.join(sorted(KNOWN))}")
    registers: dict[str, Schema] = {}
    actions: dict[str, Schema] = {}
    for number, row in enumerate(rows, 2):
        plain = {
            str(k).strip().lower(): (v or "").strip() for k, v in row.items() if isinstance(v, str)
        }
        if not any(plain.values()):
            continue
        try:
            name, register = _register(plain)
            if name in registers:
                raise ValueError(f"there are two registers {name}")
            registers[name] = register
            actions |= _actions(name, plain, Register.model_validate(register))
        except ValidationError as fault:
            raise CannotMake(f"{path}, line {number}: {first_fault(fault)}") from fault
        except ValueError as fault:
            raise CannotMake(f"{path}, line {number}: {fault}") from fault
    config: dict[str, Any] = {"resource": "10.0.0.6:502", "unit": 1, "registers": registers}
    notes = {
        "resource": "host:port, or a serial port with baud and parity",
        "unit": "its number on the line",
    }
    return Described("modbus", config, actions, notes)


def _register(row: Mapping[str, str]) -> tuple[str, Schema]:
    table = (
        row["table"].lower().removesuffix("s").removesuffix("_register").removesuffix(" register")
    )
    if table not in TABLES:
        raise ValueError(f"{row['table']!r} is no table; the tables are {', '.join(TABLES)}")
    register: Schema = {table: int(row["address"], 0)}
    register |= {key: row[key].lower() for key in ("type", "word_order") if row.get(key)}
    register |= {key: float(row[key]) for key in ("scale", "offset") if row.get(key)}
    register |= {key: int(row[key]) for key in WHOLE if row.get(key)}
    return snake(row["name"]), register


def _actions(name: str, row: Mapping[str, str], register: Register) -> dict[str, Schema]:
    schema: Schema = {"type": "number"}
    if register.is_bit or register.bit is not None:
        schema = {"type": "boolean"}
    elif register.type == "string":
        schema = {"type": "string"}
    elif (
        "int" in register.type
        and (register.scale, register.offset) == (1, 0)
        and not row.get("unit")
    ):
        schema = {"type": "integer"}
    schema |= unit(row.get("unit", ""))
    if row.get("unit") and "unit" not in schema:
        raise ValueError(f"{row['unit']!r} is no unit")
    told = re.findall(r"r(?=ead|o|w|/|$)|w", (row.get("access") or "r").lower())
    access = "".join(dict.fromkeys(told))  # manuals write R, RO, R/W, read/write
    if not access:
        raise ValueError(f"{row['access']!r} is no access: r, rw or w")
    if "w" in access and not register.writable:
        raise ValueError(f"{name} cannot be written: it lies in the table {register.table}")
    summary = {"summary": row["summary"]} if row.get("summary") else {}
    limits = {key: float(row[key]) for key in ("minimum", "maximum") if row.get(key)}
    made: dict[str, Schema] = {}
    if "r" in access:
        made[f"read_{name}"] = {"read": name, "returns": {name: schema}, **summary}
    if "w" in access:
        effect = (
            "idempotent" if "r" in access else "once"
        )  # what cannot be read back may be a command
        put = {"write": {name: f"{{{name}}}"}, "params": {name: {**schema, **limits}}}
        made[f"set_{name}"] = {**put, "effect": effect, **summary}
    return made
