"""The nodes of an OPC UA server: found by name, with their arguments and types, by asyncua."""

import asyncio
import dataclasses
import datetime
import logging
from typing import Any

from ...system.extras import needed
from .library import Refused

LONGEST_S = 3600.0
"""The library's own patience; how long is waited is said by each action."""
ALIVE_S = 20.0
"""The library looks so often whether the server is there, and gives it up if that takes as long."""
HIERARCHICAL, HAS_PROPERTY = 33, 46


async def connected(
    url: str, timeout_s: float, user: str | None, password: str | None, security: str | None
) -> Any:
    """A connected client; raises OSError or the library's own."""
    library = needed("asyncua")
    logging.getLogger("asyncua").setLevel(logging.ERROR)  # what servers grant is its own matter
    client = library.Client(url, timeout=LONGEST_S, watchdog_intervall=ALIVE_S)
    if user is not None:
        client.set_user(user)
        client.set_password(password or "")
    async with asyncio.timeout(timeout_s):
        if security is not None:
            await client.set_security_string(security)
        await client.connect()
    return client


async def node_at(client: Any, path: str) -> Any:
    """The node of a path from Objects on, or of a node id; raises Refused with what is there."""
    if path.startswith(("ns=", "i=", "s=", "g=", "b=")):
        return client.get_node(path)
    there, gone = client.nodes.objects, "Objects"
    for part in path.removeprefix("Objects/").split("/"):
        space, _, name = part.rpartition(":")
        refs = await there.get_references(refs=HIERARCHICAL, direction=0)  # forward
        found = [
            one for one in refs
            if one.BrowseName.Name == name and space in ("", str(one.BrowseName.NamespaceIndex))
        ]  # fmt: skip
        if not found:
            known = ", ".join(dict.fromkeys(one.BrowseName.Name for one in refs)) or "nothing"
            raise Refused(f"{gone} has no {part}; it has {known[:300]}")
        there, gone = client.get_node(found[0].NodeId), name
    return there


async def arguments(client: Any, method: Any, which: str) -> list[tuple[str, Any, Any]]:
    """Name, type and description (`ua.Argument`) of a method's arguments."""
    from asyncua.common.ua_utils import data_type_to_variant_type  # pyright: ignore[reportMissingImports]

    found = [
        r for r in await method.get_references(refs=HAS_PROPERTY) if r.BrowseName.Name == which
    ]
    if not found:
        return []
    told = await client.get_node(found[0].NodeId).read_value()
    types = [await data_type_to_variant_type(client.get_node(one.DataType)) for one in told]
    return [(one.Name, kind, one) for one, kind in zip(told, types, strict=True)]


def variant(value: Any, kind: Any) -> Any:
    """A value with its type; raises Refused."""
    from asyncua import ua  # pyright: ignore[reportMissingImports]

    return ua.Variant(_typed(value, kind, ua), kind)


def _typed(value: Any, kind: Any, ua: Any) -> Any:
    if isinstance(value, list):
        return [_typed(one, kind, ua) for one in value]
    whole = "Int" in kind.name or kind.name in ("Byte", "SByte")
    if whole or kind.name in ("Float", "Double"):
        if isinstance(value, str):
            raise Refused(f"{value!r} is not a number")
        if whole and int(value) != value:
            raise Refused(f"{value} is not a whole number")
        return int(value) if whole else float(value)
    return ua.LocalizedText(str(value)) if kind.name == "LocalizedText" else value


def native(found: Any) -> Any:
    """OPC UA's types as data."""
    if isinstance(found, list):
        return [native(one) for one in found]
    if dataclasses.is_dataclass(found) and not hasattr(found, "Body"):
        names = [field.name for field in dataclasses.fields(found) if hasattr(found, field.name)]
        if not {"Text", "Name"} & set(names):  # a structure
            return {name: native(getattr(found, name)) for name in names}
    if isinstance(found, datetime.datetime):
        return found.isoformat()
    for name in ("Text", "Name"):  # LocalizedText, QualifiedName
        if hasattr(found, name):
            return getattr(found, name) or ""
    return found if found is None or isinstance(found, (bool, int, float, str)) else str(found)
