"""The parameters of a protocol: the value given with `-p`, or the default, in the declared unit."""

from collections.abc import Iterator, Mapping
from typing import Any

from ...schemas.problem import Problem
from ...schemas.protocol import Param
from ...schemas.quantity import capital_slip
from ..language.source import Source
from ..language.suggest import did_you_mean, listed
from .declaration import declaration_faults
from .value import ParamFault, given_value, take

CODES = {
    "E220": "a parameter that the protocol does not have",
    "E221": "a value of the wrong type or unit for a parameter",
    "E222": "a value outside a parameter's range, pattern or choices",
    "E223": "a parameter without a value",
    "E224": "a parameter declaration that contradicts itself",
    "W221": "a unit that is the wanted one but for a capital letter",
    "W223": "a parameter that needs a value when the protocol runs",
}


def read_params(
    declared: Mapping[str, Param], given: Mapping[str, Any], source: Source, *, needed: bool = True
) -> tuple[dict[str, Any], list[Problem]]:
    """The values of all parameters that have one, and the problems found."""
    problems = list(_unknown(declared, given, source))
    values: dict[str, Any] = {}
    for name, param in declared.items():
        faults = list(declaration_faults(name, param, source))
        problems += faults
        if faults:
            continue
        try:
            if name in given:
                values[name] = take(name, param, given[name])
            elif param.default is not None:
                values[name] = take(name, param, param.default, written=True)
            else:
                problems.append(_missing(name, param, source, needed))
        except ParamFault as fault:
            problems.append(_refused(name, fault, source, by_option=name in given))
        else:
            problems += _slips(name, param, given, source)
    return values, problems


def _unknown(
    declared: Mapping[str, Param], given: Mapping[str, Any], source: Source
) -> Iterator[Problem]:
    known = {*declared, *source.names("params")}
    for name in given:
        if name not in known:
            message = f"the protocol has no parameter {name}{did_you_mean(name, declared)}"
            hint = f"it has {listed(declared)}"
            yield Problem(file="-p", line=1, column=1, code="E220", message=message, hint=hint)


def _missing(name: str, param: Param, source: Source, needed: bool) -> Problem:
    example = {"quantity": f'"1 {param.unit}"', "string": "TEXT", "boolean": "true"}.get(
        param.type, "1"
    )
    return source.problem(
        ("params", name), "E223" if needed else "W223", f"the parameter {name} has no value",
        f"give it one: -p {name}={example}, or a `default:`", key=True,
    )  # fmt: skip


def _refused(name: str, fault: ParamFault, source: Source, *, by_option: bool) -> Problem:
    if by_option:
        return Problem(
            file="-p",
            line=1,
            column=1,
            code=fault.code,
            message=f"{name}: {fault}",
            hint=fault.hint,
        )
    place = ("params", name, "default", *fault.path)
    return source.problem(place, fault.code, f"{name}: {fault}", fault.hint)


def _slips(name: str, param: Param, given: Mapping[str, Any], source: Source) -> Iterator[Problem]:
    if name in given and (slip := capital_slip(given[name], param.unit or "")):
        yield Problem(
            file="-p", line=1, column=1, code="W221", severity="warning", message=f"{name}: {slip}"
        )
    for key in ("default", "minimum", "maximum"):
        if slip := capital_slip(getattr(param, key), param.unit or ""):
            yield source.problem(("params", name, key), "W221", f"{name}: {slip}")


__all__ = ["CODES", "ParamFault", "given_value", "read_params", "take"]
