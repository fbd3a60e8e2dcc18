"""The actions of an instrument as QCoDeS describes it: units and validators of its parameters.

QCoDeS makes the parameters when an instrument is connected. Its class is connected to a stand-in
here, which answers enough for that; nothing of what it answers is written. Of channels that are
alike the first is described.
"""

import inspect
import logging
import math
import re
import time
from collections.abc import Iterator
from contextlib import redirect_stdout
from itertools import product
from typing import Any
from unittest.mock import patch

from ....drivers.bridges.library import instrument_class
from ....drivers.bridges.qcodes import PACKAGE, choice_text
from ....schemas.quantity import is_number
from ..protocol import CannotMake
from .metadata import choices, method, unit
from .sources import Described

Actions = dict[str, dict[str, Any]]
ANSWERS = ("0", "1", "50", "VOLT", "SCPI", "", "0,0,0,0,0,0", "a,b,c,d", '"SIN,1,1,0"', "520,1EU")
"""What constructors ask for: numbers, the frequency of the mains, a mode, the model, a list, an option."""
TRIED_S = 6.0
RESOURCES = ("GPIB0::1::INSTR", "TCPIP0::127.0.0.1::7020::SOCKET")
LEFT_OUT = {"IDN", "timeout"}


def describe(source: str) -> Described:
    """The instrument behind `qcodes:MODULE.CLASS`; raises CannotMake and OSError."""
    name = source.partition(":")[2]
    found = instrument_class("QCoDeS", PACKAGE, name)
    actions, config = _known(name, found)
    if not actions:
        raise CannotMake(f"{name} has no parameters or methods that could be actions")
    return Described(
        driver="qcodes",
        config={"instrument": name, **config},
        notes={"resource": "where it is, as VISA names it"},
        actions=actions,
    )


def _known(name: str, found: Any) -> tuple[Actions, dict[str, Any]]:
    """The actions of an instrument of this class, and what its config needs."""
    from qcodes.instrument import (  # pyright: ignore[reportMissingImports]
        Instrument,
        VisaInstrument,
    )

    if not (isinstance(found, type) and issubclass(found, Instrument)):
        raise CannotMake(f"{name} is not a class of instruments of QCoDeS")
    logging.disable(logging.CRITICAL)
    try:
        with redirect_stdout(None):  # it greets on its connection
            if not issubclass(found, VisaInstrument):
                return dict(_actions(found("described"), "")), {}
            return max(_tried(found, VisaInstrument), key=lambda made: len(made[0]))
    except Exception as fault:  # whatever a class raises that wants more than a name
        raise CannotMake(
            f"QCoDeS cannot say what {name} has without the instrument or more arguments ({fault}); "
            "name its parameters by hand, as `get: voltage`"
        ) from fault
    finally:
        Instrument.close_all()
        logging.disable(logging.NOTSET)


def _tried(found: Any, visa: Any) -> list[tuple[Actions, dict[str, Any]]]:
    """What it has, by what the stand-in answers; raises the first fault if nothing will do."""
    made: list[tuple[Actions, dict[str, Any]]] = []
    faults: list[Exception] = []
    models = re.findall(r"(?=([A-Z]*\d\w*))", found.__name__)[:3] or [found.__name__]
    models += [re.sub(r"T?P$", r"-\g<0>", model) for model in models]
    until = time.monotonic() + TRIED_S
    for answer, model, resource in product(ANSWERS, dict.fromkeys(models), RESOURCES):
        if time.monotonic() > until:
            break
        silent = _Silent(model, answer or model, until)
        try:
            with patch.object(visa, "_open_resource", lambda *_, s=silent: s):
                instrument = found("described", resource)
                made.append((dict(_actions(instrument, "")), {"resource": resource}))
        except Exception as fault:  # as above; it is told if no answer will do
            faults.append(fault)
        finally:
            visa.close_all()
    if not made:
        raise faults[0]
    return made


class _Silent:
    """A VISA resource to which nothing is connected."""

    resource_name, session, timeout = RESOURCES[0], None, 5000.0
    read_termination = write_termination = "\n"

    def __init__(self, model: str, answer: str, until: float) -> None:
        self.model, self.answer, self.until, self.asked = model, answer, until, ""

    def write(self, text: str = "", *_: Any, **__: Any) -> int:
        self.asked = text
        return len(text)

    def query(self, text: str, *_: Any, **__: Any) -> str:
        if time.monotonic() > self.until:  # a constructor that waits for something
            raise TimeoutError(f"it asks {text} without end")
        idn = "*idn?" in text.lower()
        return f"QCoDeS,{self.model},0,0" if idn else self.answer

    def read(self, *_: Any, **__: Any) -> str:
        return self.query(self.asked)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_, **__: self.answer


def _actions(there: Any, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    for name, parameter in there.parameters.items():
        if name not in LEFT_OUT:
            yield from _parameter(f"{path}{name}", name, parameter)
    from qcodes.instrument import (  # pyright: ignore[reportMissingImports]
        Instrument,
        InstrumentModule,
        VisaInstrument,
    )

    base = {*dir(Instrument), *dir(VisaInstrument), *dir(InstrumentModule)}
    for name in sorted(set(dir(type(there))) - base):
        one = inspect.getattr_static(type(there), name)
        if not name.startswith("_") and inspect.isfunction(one):
            said = method(f"{path}{name}", one)
            if said is not None:
                yield _named("", f"{path}{name}"), said
    described: set[Any] = set()
    for name, module in there.submodules.items():
        kind = (type(module), frozenset(getattr(module, "parameters", ())))
        if kind not in described and hasattr(module, "parameters"):
            described.add(kind)
            yield from _actions(module, f"{path}{name}.")


def _parameter(path: str, name: str, one: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    several = getattr(one, "names", None)
    schema = _schema(one)
    if schema is None:
        return
    if one.gettable and several:  # a MultiParameter
        units = [unit(text) for text in getattr(one, "units", None) or [""] * len(several)]
        shapes = getattr(one, "shapes", None) or [()] * len(several)
        fields = zip(several, units, shapes, strict=False)
        returns = {_named("", str(n)): _shaped({"type": "number", **u}, s) for n, u, s in fields}
        yield _named("read_", path), {"get": path, "returns": returns}
    elif one.gettable:
        plain = {k: v for k, v in schema.items() if k in ("type", "unit", "items")}
        plain = _shaped(plain, getattr(one, "shape", None) or ())
        yield _named("read_", path), {"get": path, "returns": {_named("", name): plain}}
    if one.settable and not several:
        params = {_named("", name): schema}
        yield _named("set_", path), {"set": path, "params": params, "effect": "idempotent"}


def _named(verb: str, path: str) -> str:
    return verb + re.sub(r"\W+", "_", path).strip("_")


def _shaped(schema: dict[str, Any], shape: Any) -> dict[str, Any]:
    return {"type": "array", "items": schema} if shape else schema


def _schema(one: Any) -> dict[str, Any] | None:
    """The schema of a parameter's value; None for what JSON has no counterpart of."""
    with_unit = unit(getattr(one, "unit", None) or "")
    mapping = getattr(one, "val_mapping", None)
    if mapping and {True, False} <= {key for key in mapping if isinstance(key, bool)}:
        return {"type": "boolean"}  # beside its words for on and off
    if mapping:
        return choices([choice_text(key) for key in mapping])
    validator = getattr(one, "vals", None)
    for part in getattr(validator, "validators", None) or [validator]:
        found = _validated(part, with_unit)
        if found != {}:
            return found
    if with_unit or getattr(one, "get_parser", None) in (float, int):
        return {"type": "number", **with_unit}
    known = getattr(one.cache, "_value", None)
    text = isinstance(getattr(one, "get_cmd", None), str) or isinstance(known, str)
    return {"type": "string" if text else "number"}


def _validated(part: Any, with_unit: dict[str, Any]) -> dict[str, Any] | None:
    """What a validator allows; nothing if it says nothing."""
    match type(part).__name__:
        case "Enum" | "OnOff" | "LiteralValidator":
            allowed = part.values if hasattr(part, "values") else part._valid_values
            made = choices(sorted((choice_text(x) for x in allowed if x is not None), key=str))
            return {**made, **(with_unit if is_number(made.get("enum", [""])[0]) else {})}
        case "Bool":
            return {"type": "boolean"}
        case "Strings":
            return {"type": "string"}
        case "Numbers" | "Ints" | "PermissiveInts":
            whole = type(part).__name__ != "Numbers"
            ends = {"minimum": part.min_value, "maximum": part.max_value}
            limits = {n: v for n, v in ends.items() if math.isfinite(v) and abs(v) < 1e18}
            return {"type": "integer" if whole else "number", **with_unit, **limits}
        case "Arrays" | "Lists" | "Sequence":
            return {"type": "array", "items": {"type": "number", **with_unit}}
        case "ComplexNumbers" | "Dict" | "Callable" | "ObjectTypeValidator":
            return None
    return {}
