"""The actions of an OPC UA server, found by browsing it: variables are read and set, methods called.

Units and ranges are those of its EngineeringUnits and EURange (OPC 10000-8).
"""

import asyncio
from typing import Any

from ....drivers.bridges.opcua_nodes import HIERARCHICAL, arguments, connected
from ..protocol import CannotMake
from .metadata import Schema, unit
from .names import STOPS, short_names, snake
from .sources import Described

SERVER, TYPES = 2253, 23470
"""Nodes of namespace 0 that every server has: itself, and aliases."""
VARIABLE, METHOD, OBJECT = 2, 4, 1
MOST_NODES, CONNECT_S = 3000, 10.0
NUMBERS = ("Float", "Double")
WHOLE = ("Byte", "SByte", "Int16", "Int32", "Int64", "UInt16", "UInt32", "UInt64", "Enumeration")
TEXTS = ("String", "LocalizedText", "DateTime", "QualifiedName", "Guid")
Found = tuple[tuple[str, ...], Schema]


def describe(source: str) -> Described:
    """The server at `opc.tcp://host:port/path`; raises CannotMake."""
    try:
        found = asyncio.run(_browsed(source))
    except Exception as fault:  # the library's own, and OSError
        raise CannotMake(f"{source}: {fault or type(fault).__name__}") from fault
    if not found:
        raise CannotMake(f"{source} has no variables and no methods of its own")
    variables = [one for one in found if "call" not in one[1]]
    methods = [one for one in found if "call" in one[1]]
    actions: dict[str, Schema] = {}
    for name, (_, said) in zip(short_names([p for p, _ in variables]), variables, strict=True):
        path, schema, limits = said["path"], said["schema"], said["limits"]
        returns = said["parts"] or {"value": schema}
        actions[f"read_{name}"] = {"get": path, "returns": returns}
        if said["writable"]:
            params = {"value": {**schema, **limits}}
            actions[f"set_{name}"] = {"set": path, "params": params, "effect": "idempotent"}
    config: dict[str, Any] = {"url": source}
    for name, (_, said) in zip(short_names([p for p, _ in methods]), methods, strict=True):
        stops = name in STOPS and "params" not in said
        actions[name] = {**said, "effect": "idempotent" if stops else "once"}
        if stops:
            config["abort"] = name
    return Described("opcua", config, actions)


async def _browsed(url: str) -> list[Found]:
    client = await connected(url, CONNECT_S, None, None, None)
    try:
        found: list[Found] = []
        await _browse(client, client.nodes.objects, (), found, {})
        return found
    finally:
        await client.disconnect()


async def _browse(
    client: Any, node: Any, path: tuple[str, ...], found: list[Found], seen: dict[Any, None]
) -> None:
    for ref in await node.get_references(refs=HIERARCHICAL, direction=0):
        name, ident = ref.BrowseName.Name, ref.NodeId
        own = ident.NamespaceIndex == 0 and ident.Identifier in (SERVER, TYPES)
        is_property = (
            ref.ReferenceTypeId.Identifier == 46 and ref.ReferenceTypeId.NamespaceIndex == 0
        )
        if own or is_property or ident in seen or "/" in name or len(seen) >= MOST_NODES:
            continue
        seen[ident] = None
        there, below, kind = client.get_node(ident), (*path, name), int(ref.NodeClass)
        if kind == VARIABLE and (said := await _variable(client, there)) is not None:
            found.append((below, {"path": "/".join(below), **said}))
        elif kind == METHOD and (said := await _method(client, there)) is not None:
            found.append((below, {"call": "/".join(below), **said}))
        if kind in (OBJECT, VARIABLE):
            await _browse(client, there, below, found, seen)


async def _variable(client: Any, node: Any) -> Schema | None:
    kind = (await node.read_data_type_as_variant_type()).name
    rank = await node.read_value_rank()
    parts = await _parts(client, await node.read_data_type(), kind, rank, "")
    schema = _schema(kind, rank) or {}
    if not (schema or parts):
        return None
    limits: Schema = {}
    for ref in await node.get_references(refs=46, direction=0):
        if ref.BrowseName.Name == "EngineeringUnits" and schema.get("type") in (
            "number",
            "integer",
        ):
            units = await client.get_node(ref.NodeId).read_value()
            schema |= unit((units and units.DisplayName.Text) or "")
        if ref.BrowseName.Name == "EURange":
            wide = await client.get_node(ref.NodeId).read_value()
            if wide is not None and wide.Low < wide.High:
                limits = {"minimum": wide.Low, "maximum": wide.High}
    allowed = {one.name for one in await node.get_user_access_level()}
    writable = "CurrentWrite" in allowed and not parts
    return (
        {"schema": schema, "limits": limits, "writable": writable, "parts": parts}
        if "CurrentRead" in allowed
        else None
    )


async def _method(client: Any, node: Any) -> Schema | None:
    told = {}
    for key, which in (("params", "InputArguments"), ("returns", "OutputArguments")):
        schemas: dict[str, Any] = {}
        for name, kind, one in await arguments(client, node, which):
            given = (one.DataType, kind.name, one.ValueRank, f"{name}.")
            parts = await _parts(client, *given) if key == "returns" else {}
            schemas |= parts or {snake(name): _schema(kind.name, one.ValueRank)}
            if None in schemas.values():
                return None
        if schemas:
            told[key] = schemas
    return told


async def _parts(client: Any, kind: Any, name: str, rank: int, before: str) -> dict[str, Schema]:
    """The fields of a structure that are values, and where each is found; none for anything else."""
    if name != "ExtensionObject" or rank >= 0:
        return {}
    from asyncua.common.ua_utils import data_type_to_variant_type  # pyright: ignore[reportMissingImports]

    try:
        said = await client.get_node(kind).read_data_type_definition()
    except Exception:  # a server need not say it
        return {}
    found: dict[str, Schema] = {}
    for one in getattr(said, "Fields", None) or ():
        inner = (await data_type_to_variant_type(client.get_node(one.DataType))).name
        if (schema := _schema(inner, one.ValueRank)) is not None:
            found[snake(one.Name)] = {**schema, "at": f"{before}{one.Name}"}
    return found


def _schema(kind: str, rank: int) -> Schema | None:
    names = (
        {"Boolean": "boolean"} | dict.fromkeys(NUMBERS, "number") | dict.fromkeys(WHOLE, "integer")
    )
    found = (names | dict.fromkeys(TEXTS, "string")).get(kind)
    if found is None:
        return None
    return {"type": "array", "items": {"type": found}} if rank >= 0 else {"type": found}
