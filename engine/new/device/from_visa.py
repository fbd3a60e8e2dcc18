"""The actions of an SCPI instrument, as far as it says them itself: SYSTem:HELP:HEADers?

SCPI 1999.0, volume 2, 21.9: each line a command with its short form in capitals, `/qonly/` what can only be
asked, `/nquery/` what can only be sent. Few instruments know it; of any other only *IDN? is known.
"""

import asyncio
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ....drivers.bridges.lines import NoAnswer
from ....drivers.bridges.resource import read_resource
from ....drivers.bridges.scpi import Scpi
from ....drivers.driver import Place
from ..protocol import CannotMake
from .metadata import Schema
from .sources import Described

HELP, HELP_S = "SYST:HELP:HEAD?", 3.0
SPECIAL = re.compile(r"([.^$*+?{}\[\]\\|()])")
HEADER = re.compile(r":?(?P<name>[A-Za-z][A-Za-z0-9:]*)\??(?P<kind>/qonly/|/nquery/)?")
TEXT: Schema = {"type": "string"}
IDENTITY: Schema = {"query": "*IDN?", "returns": {"identity": TEXT}}
RESET: Schema = {"write": "*RST", "wait": True, "effect": "once"}
LEFT_OUT = ("SYSTEM:HELP", "SYSTEM:ERROR", "SYST:HELP", "SYST:ERR")


def describe(source: str) -> Described:
    """The instrument at `visa:RESOURCE`, also `visa:host:port`; raises CannotMake."""
    resource = source.partition(":")[2]
    try:
        read_resource(resource)
        identity, headers = asyncio.run(_asked(resource))
    except (OSError, ValueError) as fault:
        raise CannotMake(str(fault)) from fault
    model = SPECIAL.sub(r"\\\1", identity.split(",")[1].strip()) if "," in identity else True
    actions: dict[str, Schema] = {"identity": IDENTITY, "reset": RESET}
    for line in headers:
        actions |= _actions(line.strip())
    config = {"resource": resource, "idn": model}
    notes = {"idn": f"{identity}; it said {len(headers)} commands of its own"}
    return Described("scpi", config, actions, notes)


async def _asked(resource: str) -> tuple[str, list[str]]:
    with TemporaryDirectory() as folder:
        config = {"resource": resource, "timeout": HELP_S, "actions": {"identity": IDENTITY}}
        made = Scpi(Place("instrument", config, {}, Path(folder), Path(folder)))
        await made.open()
        try:
            identity = made._identity or ""
            await made.lines.send(HELP)
            try:
                told = await made.lines.block(HELP, HELP_S)
            except NoAnswer:
                return identity, []
            return identity, told.decode("latin-1").splitlines()
        finally:
            await made.close()


def _actions(line: str) -> dict[str, Any]:
    """What one line of help says; nothing where its header has parts that may be left out or counted."""
    found = HEADER.fullmatch(line)
    if found is None or found["name"].upper().startswith(LEFT_OUT):
        return {}
    name, said = found["name"].replace(":", "_").lower(), found["name"]
    made: dict[str, Schema] = {}
    if found["kind"] != "/nquery/":
        made[f"read_{name}"] = {"query": f"{said}?", "returns": {"value": TEXT}}
    if found["kind"] is None:
        value = {"write": f"{said} {{value}}", "params": {"value": TEXT}}
        made[f"set_{name}"] = {**value, "effect": "idempotent"}
    elif found["kind"] == "/nquery/":
        made[name] = {"write": said, "effect": "once"}
    return made
