"""The actions of a device as ophyd and ophyd-async describe it: its signals, and what moves it.

A device that needs no hardware, or whose prefix is given (`ophyd:ophyd.EpicsMotor@IOC:m1`), is
connected, and says units, limits and choices itself; of any other its class says which signals
there are.
"""

import asyncio
import contextlib
import inspect
import math
from collections.abc import AsyncIterator, Iterator
from typing import Any

from ....drivers.bridges.library import instrument_class
from ....drivers.bridges.ophyd import PACKAGE, field, made_device
from ..protocol import CannotMake
from .metadata import Schema, choices, method, of_annotation, unit
from .sources import LONG, Described

CONNECT_S = 5.0
NO_PREFIX = "XX:"
PLANS = ("trigger", "stage", "unstage", "kickoff", "complete", "prepare", "unprime")
TEXTS = ("name", "path", "desc", "egu", "template", "version", "message")
JSON = {"number": "number", "integer": "integer", "string": "string", "boolean": "boolean"}


def describe(source: str) -> Described:
    """The device behind `ophyd:MODULE.CLASS` or `ophyd:MODULE.CLASS@PREFIX`; raises CannotMake."""
    instrument, _, prefix = source.partition(":")[2].partition("@")
    try:
        found = instrument_class("ophyd", PACKAGE, instrument)
        actions, needs_prefix = asyncio.run(_known(found, prefix))
    except TimeoutError as fault:  # whose text is all of its signals
        first = str(fault).partition(", ")[0]
        told = f"{instrument}: nothing answers as {prefix}; is its IOC on, and is this its prefix? ({first})"
        raise CannotMake(told) from fault
    except Exception as fault:  # whatever a class raises that wants more than a name
        raise CannotMake(f"{instrument}: {fault}") from fault
    if not actions:
        raise CannotMake(f"{instrument} has no signals of its own, and nothing moves it")
    config: dict[str, Any] = {"instrument": instrument}
    if needs_prefix:
        config["prefix"] = prefix or NO_PREFIX
    if "stop" in actions:
        config |= {"abort": "stop", "safe_state": ["stop"]}
    return Described(
        driver="ophyd", config=config, actions=actions,
        notes={"prefix": "that of its names in EPICS"},
    )  # fmt: skip


Signals = list[tuple[str, bool, bool, Schema]]
"""Path, whether it can be read, whether it can be set, and what it holds."""


async def _known(found: Any, prefix: str) -> tuple[dict[str, Any], bool]:
    """The actions, and whether the config needs a prefix."""
    if _needs_epics(found) and not prefix:
        return dict(_actions(found, list(_of_class(found, "")), {})), True
    made, prefixed = _made(found, prefix)
    if not hasattr(made, "connect"):
        if hasattr(made, "wait_for_connection"):
            made.wait_for_connection(timeout=CONNECT_S)
        reading = made.describe() if hasattr(made, "describe") else {}
        return dict(_actions(made, _of_device(made), reading)), prefixed
    reading: dict[str, Any] = {}
    with contextlib.suppress(Exception):  # without its hardware it still has its signals
        await made.connect(timeout=CONNECT_S if prefix or not prefixed else 0.01)
        reading = await made.describe()
    return dict(_actions(made, [s async for s in _of_async(made, "")], reading)), prefixed


def _made(found: Any, prefix: str) -> tuple[Any, bool]:
    """The device, and whether its class takes a prefix."""
    if not callable(found):  # a module of devices that are already made
        return found, False
    parameters = inspect.signature(found).parameters
    prefixed = "prefix" in parameters and (bool(prefix) or not _optional(found, parameters))
    needed = {
        n: None for n, p in parameters.items()
        if p.default is p.empty and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    }  # fmt: skip
    if lacking := [name for name in needed if name not in ("prefix", "name")]:
        raise TypeError(
            f"it needs {', '.join(lacking)}: write a function that returns the device, and name that"
        )
    return made_device(found, (prefix or NO_PREFIX) if prefixed else None, {}), prefixed


def _optional(found: Any, parameters: Any) -> bool:
    """Whether it is made without a prefix: devices of ophyd all take one, and some ignore it."""
    default = parameters["prefix"].default
    return default is not inspect.Parameter.empty and "epics" not in found.__module__


def _needs_epics(found: Any) -> bool:
    """Whether a class of ophyd declares signals of EPICS."""
    parts = [one.cls for one in getattr(found, "_sig_attrs", {}).values()]
    return any("Epics" in part.__name__ or _needs_epics(part) for part in parts)


def _of_class(found: Any, path: str) -> Iterator[tuple[str, bool, bool, Schema]]:
    """The signals that a class of ophyd declares."""
    for name, one in getattr(found, "_sig_attrs", {}).items():
        if getattr(one.cls, "_sig_attrs", None):
            yield from _of_class(one.cls, f"{path}{name}.")
        elif not hasattr(one, "defn"):
            kind, text = one.cls.__name__, bool(one.kwargs.get("string"))
            text = text or "Path" in kind or name.rpartition("_")[2] in TEXTS
            schema = {"type": "string" if text else "number"}
            yield f"{path}{name}", True, not kind.endswith("RO"), schema


def _of_device(made: Any) -> Signals:
    """The signals of a connected device of ophyd, as they describe themselves."""
    walked = made.walk_signals(include_lazy=True) if hasattr(made, "walk_signals") else ()
    found = [(dotted, one) for _, dotted, one in walked] or [("", made)]
    signals: Signals = []
    for path, one in found:
        if not hasattr(one, "get"):  # a part that moves, which `read` knows
            continue
        try:
            said = next(iter(one.describe().values()))
        except Exception:  # one of a hundred signals that is not there
            continue
        if path:
            signals.append((path, True, bool(getattr(one, "write_access", True)), _schema(said)))
    return signals


async def _of_async(made: Any, path: str) -> AsyncIterator[tuple[str, bool, bool, Schema]]:
    """The signals of a device of ophyd-async, with their types."""
    for name, one in made.children():
        kind = next((k.__name__ for k in type(one).__mro__ if k.__name__ in KINDS), None)
        if kind is None:
            async for found in _of_async(one, f"{path}{name}."):
                yield found
            continue
        schema = of_annotation(getattr(one, "datatype", None))
        if schema is None:
            continue
        with contextlib.suppress(Exception):  # only what is connected knows its unit and limits
            schema |= _schema(next(iter((await one.describe()).values())), schema)
        yield f"{path}{name}", *KINDS[kind], schema


KINDS = {"SignalRW": (True, True), "SignalR": (True, False), "SignalW": (False, True)}


def _schema(said: dict[str, Any], known: Schema | None = None) -> Schema:
    """What a description says: bluesky's data key."""
    if said.get("enum_strs") or said.get("choices"):
        return choices(said.get("enum_strs") or said["choices"])
    kind = (known or {}).get("type") or JSON.get(said.get("dtype", "number"), "number")
    if said.get("dtype") == "array":
        return {"type": "array", "items": {"type": "number", **unit(said.get("units") or "")}}
    if kind not in ("number", "integer"):
        return {"type": kind}
    low, high = said.get("lower_ctrl_limit"), said.get("upper_ctrl_limit")
    limits = {"minimum": low, "maximum": high} if low is not None and high is not None else {}
    limits = limits if low != high and all(math.isfinite(v) for v in limits.values()) else {}
    # EPICS and the simulations say `integer` of a float that happens to be whole.
    return {"type": "number", **unit(said.get("units") or ""), **limits}


def _actions(made: Any, signals: Signals, reading: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Of a device, or of a class that is not connected."""
    kind = made if isinstance(made, type) else type(made)
    if reading:
        returns = {field(name, made.name): _schema(said) for name, said in reading.items()}
        plain = {n: {k: v for k, v in s.items() if k in KEPT} for n, s in returns.items()}
        yield "read", {"call": "read", "effect": "pure", "returns": plain}
    for path, readable, settable, schema in signals:
        plain, name = path.replace(".", "_"), path.rpartition(".")[2]
        name = name if not name.isdigit() else plain
        returned = {k: v for k, v in schema.items() if k in KEPT}
        if readable:
            yield f"read_{plain}", {"get": path, "returns": {name: returned}}
        if settable:
            yield f"set_{plain}", {"set": path, "params": {name: schema}, "effect": "idempotent"}
    yield from _methods(kind, signals)


NOT_ACTIONS = ("set", "stop", "move", "check_value", "get_lim", "set_lim", "wait_for_connection")
BASE = ("ophyd.device", "ophyd.ophydobj", "ophyd.signal", "ophyd.positioner", "ophyd.pseudopos",
        "ophyd.areadetector.base", "ophyd.flyers", "ophyd_async.core", "abc", "typing")  # fmt: skip
KEPT = ("type", "unit", "items")


def _methods(kind: type, signals: Signals) -> Iterator[tuple[str, dict[str, Any]]]:
    stops = callable(getattr(kind, "stop", None))
    movable = callable(getattr(kind, "set", None)) and stops
    if movable:
        target = next(iter(list(inspect.signature(kind.set).parameters)[1:]))  # type: ignore[attr-defined]
        ends = next((s for p, _, w, s in signals if "setpoint" in p and w), {"type": "number"})
        yield "move", {"call": "set", "params": {target: ends}, "effect": "idempotent", **LONG,
                       "cancel": True}  # fmt: skip
    if stops:
        yield "stop", {"call": "stop", "effect": "idempotent"}
    own = _own_methods(kind) | {n for n in PLANS if callable(getattr(kind, n, None))}
    for name in sorted(own):
        said = method(name, getattr(kind, name))
        if said is not None and name not in NOT_ACTIONS:
            yield name, {**said, **(LONG if name in ("trigger", "complete") else {})}


def _own_methods(kind: type) -> set[str]:
    """Names of methods that the library's base classes do not have."""
    base, own = set[str](), set[str]()
    for one in kind.__mro__:
        (base if one is object or one.__module__.startswith(BASE) else own).update(vars(one))
    plain = (n for n in own - base if inspect.isfunction(inspect.getattr_static(kind, n)))
    return {name for name in plain if not name.startswith("_")}
