"""The actions of a SiLA 2 server, as the definitions of its features say them.

A property is read, a command that begins with Set sets; SiLA says nothing of the effect of others.
"""

from collections.abc import Iterator
from typing import Any

from ....drivers.bridges.sila2 import connected
from ..protocol import CannotMake
from .metadata import Schema, unit
from .names import STOPS, short_names, snake
from .sources import Described

CORE = "org.silastandard/core"
KINDS = {"Boolean": "boolean", "Integer": "integer", "Real": "number", "String": "string"}
LIMITS = {
    "MaximalInclusive": "maximum", "MinimalInclusive": "minimum",
    "MaximalExclusive": "exclusiveMaximum", "MinimalExclusive": "exclusiveMinimum",
}  # fmt: skip
LONG = {"timeout": "10 min", "duration": "10 s"}
"""For observable commands: the reader knows better."""


def describe(source: str) -> Described:
    """The server at `sila2://host:port`, with `?insecure` or `?root_certs=ca.pem`; raises CannotMake."""
    url, _, said = source.partition("?")
    plain, certs = said == "insecure", said.removeprefix("root_certs=")
    if said and not plain and certs in ("", said):
        raise CannotMake(f"{source}: after the address may stand ?insecure or ?root_certs=FILE.pem")
    certs = "" if plain else certs
    config: dict[str, Any] = {"url": url} | ({"root_certs": certs} if certs else {})
    if plain:
        config["insecure"] = True
    try:
        try:
            client = connected(url, insecure=plain, root_certs=certs or None)
        except Exception as fault:  # known by name alone: the library need not be installed
            if said or type(fault).__name__ != "SilaConnectionError":
                raise
            client = connected(url, insecure=True, root_certs=None)
            config["insecure"] = True
    except Exception as fault:  # the library's own, and OSError
        raise CannotMake(
            f"{url}: {fault}; a server with a certificate of its own is reached by "
            f"{url}?root_certs=FILE.pem"
        ) from fault
    try:
        found = list(_actions(client))
    finally:
        client.close()
    if not found:
        raise CannotMake(f"{url} has no feature but those of SiLA itself")
    names = short_names([path.split(".") for path, _ in found])
    actions = dict(zip(names, (said for _, said in found), strict=True))
    for name in STOPS & actions.keys():
        if "params" not in actions[name]:
            config["abort"] = name
    return Described("sila2", config, actions)


def _actions(client: Any) -> Iterator[tuple[str, Schema]]:
    """Path and action; what has a type that JSON has no counterpart of is left out."""
    for name, feature in client._features.items():
        if str(feature.fully_qualified_identifier).startswith(CORE):
            continue
        for one in (
            *feature._unobservable_properties.values(),
            *feature._observable_properties.values(),
        ):
            returns = dict(_inside(one.data_type, "")) or _fields(
                [(one._identifier, one.data_type)]
            )
            if returns is not None:
                yield (
                    f"{name}.{one._identifier}",
                    {"get": f"{name}.{one._identifier}", "returns": returns},
                )
        for one in feature._unobservable_commands.values():
            yield from _command(name, one, {})
        for one in feature._observable_commands.values():
            yield from _command(name, one, LONG)


def _command(feature: str, command: Any, more: Schema) -> Iterator[tuple[str, Schema]]:
    path, name = f"{feature}.{command._identifier}", snake(command._identifier)
    params = _fields([(one._identifier, one.data_type) for one in command.parameters], given=True)
    returns = _fields([(one._identifier, one.data_type) for one in command.responses])
    for one in command.responses:
        returns = {**dict(_inside(one.data_type, f"{one._identifier}.")), **(returns or {})}
    if params is None:
        return
    errors = {
        error._identifier: {
            "happened": "unknown",
            "summary": " ".join(str(error._description).split()),
        }
        for error in command.defined_execution_errors
    }
    setting = (name.startswith("set_") and bool(params)) or (name in STOPS and not params)
    said: Schema = {"call": path}
    said |= {"params": params} if params else {}
    said |= {"returns": returns} if returns else {}
    said |= {"effect": "idempotent" if setting else "once"} | ({"errors": errors} if errors else {})
    yield path, {**said, **more}


def _fields(parts: list[tuple[str, Any]], *, given: bool = False) -> Schema | None:
    """Name -> schema; None if one of them has none."""
    schemas = {snake(name): _schema(kind) for name, kind in parts}
    if not given:  # what is measured may lie beyond what can be set
        schemas = {name: _boundless(schema) for name, schema in schemas.items()}
    if given or len(parts) == 1:
        return None if None in schemas.values() else schemas
    return {name: schema for name, schema in schemas.items() if schema is not None}


def _inside(kind: Any, place: str) -> Iterator[tuple[str, Schema]]:
    """The values in a structure, and where each is found; none of anything else."""
    while type(kind).__name__ == "DataTypeDefinition":
        kind = kind.data_type
    for one in kind.fields if type(kind).__name__ == "Structure" else ():
        where = f"{place}{one._identifier}"
        yield from _inside(one.data_type, f"{where}.")
        if (schema := _boundless(_schema(one.data_type))) is not None:
            yield snake(one._identifier), {**schema, "at": where}


def _boundless(schema: Schema | None) -> Schema | None:
    if schema is None:
        return None
    kept = {key: one for key, one in schema.items() if key not in LIMITS.values()}
    return kept | ({"items": _boundless(kept["items"])} if "items" in kept else {})


def _schema(kind: Any) -> Schema | None:
    name = type(kind).__name__
    if name in KINDS:
        return {"type": KINDS[name]}
    if name == "DataTypeDefinition":
        return _schema(kind.data_type)
    if name == "List":
        items = _schema(kind.element_type)
        return {"type": "array", "items": items} if items is not None else None
    if name != "Constrained" or (schema := _schema(kind.base_type)) is None:
        return None
    for one in kind.constraints:
        limit = type(one).__name__
        if limit == "Unit":
            schema |= unit(one.label)
        elif limit in LIMITS and schema["type"] in ("number", "integer"):
            schema[LIMITS[limit]] = one.reference_value
        elif limit == "Set":
            schema["enum"] = list(one.set_values)
    return schema
