"""Fit the arguments of an action to its contract: units, types, ranges, the limits of this bench."""

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from ...schemas.contract import Action
from ...schemas.lab import Limit
from ...schemas.protocol import StepBase
from .argument import fit, plain, validator
from .suggest import did_you_mean, listed
from .wanted import ArgumentFault, Wanted

OF_STEPS = {*StepBase.model_fields, "mode"}
EACH = {"type", "properties", "required", "additionalProperties"}
"""Rules of an action's parameters that are kept where each of them fits, and all are there."""


class ArgumentFaults(ValueError):
    """Everything that is wrong with the arguments of one action."""

    def __init__(self, faults: list[ArgumentFault]) -> None:
        super().__init__("; ".join(fault.with_hint() for fault in faults))
        self.faults = faults


def resolve_arguments(
    action: Action, given: Mapping[str, Any], limits: Mapping[str, Limit], *, label: str
) -> dict[str, Any]:
    """The arguments as the driver gets them: bare numbers in the contract's units.

    Raises ArgumentFaults with all faults.
    """
    resolved, faults = fit_arguments(action, given, limits, label=label)
    if faults:
        raise ArgumentFaults(faults)
    return resolved


def typed(text: str, schema: Mapping[str, Any]) -> Any:
    """What a person has typed for a value: JSON, unless the schema says that it is text."""
    if schema.get("type") == "string":
        return text
    try:
        return json.loads(text)
    except ValueError:
        return text


def fit_arguments(
    action: Action, given: Mapping[str, Any], limits: Mapping[str, Limit], *, label: str,
    later: Iterable[str] = (),
) -> tuple[dict[str, Any], list[ArgumentFault]]:  # fmt: skip
    """The arguments that fit, and the faults of the others.

    `later`: names of parameters whose values are not known yet; they count as given.
    """
    schemas = action.param_schemas()
    faults = list(unknown_arguments(action, given, label))
    resolved: dict[str, Any] = {}
    for name, value in given.items():
        if name in schemas:
            wanted = Wanted(schemas[name], limits.get(name), name, label)
            try:
                resolved[name] = fit(value, wanted)
            except ArgumentFault as fault:
                faults.append(fault)
    names = {*given, *later}
    faults += missing_arguments(action, names, label)
    if not faults and not set(later):
        faults += _whole(action, resolved, label)
    return resolved, faults


def unknown_arguments(action: Action, names: Iterable[str], label: str) -> Iterator[ArgumentFault]:
    """Arguments that the action does not have."""
    known = action.param_schemas()
    if action.params.get("additionalProperties", False) is not False:
        return
    for name in names:
        if name not in known:
            takes = f"it takes {listed(known)}" if known else "it takes no parameters"
            if name in OF_STEPS:
                takes = f"`{name}` belongs to the step: write it beside `with`; {takes}"
            message = f"{label} has no parameter {name}{did_you_mean(name, known)}"
            yield ArgumentFault(name, message, takes, code="E203")


def missing_arguments(action: Action, names: Iterable[str], label: str) -> list[ArgumentFault]:
    """Required parameters that are missing."""
    given = set(names)
    return [
        ArgumentFault(name, f"{label} needs {name}", _example(name, action), code="E205")
        for name in action.required()
        if name not in given
    ]


def _example(name: str, action: Action) -> str:
    schema = action.param_schemas().get(name, {})
    unit = schema.get("unit")
    says = schema.get("description", "") or schema.get("summary", "")
    return f"with: {{{name}: {f'1 {unit}' if unit else '...'}}}{f'   ({says})' if says else ''}"


def _whole(action: Action, resolved: dict[str, Any], label: str) -> list[ArgumentFault]:
    """Faults of the parameters as a whole, such as `minProperties`."""
    others = action.params.get("additionalProperties", False)
    if action.params.keys() <= EACH and isinstance(others, bool):
        return []  # each of them fits, none is missing, and none is unknown
    found = []
    for fault in validator(action.params).iter_errors(resolved):
        if fault.absolute_path:
            continue
        if fault.validator == "minProperties":
            says = f"{label} needs at least {fault.validator_value} of {listed(action.param_schemas())}"
        else:
            says = f"{label}: {plain(fault)}"
        found.append(ArgumentFault("", says, code="E205", path=()))
    return found


__all__ = ["ArgumentFault", "ArgumentFaults", "fit_arguments", "resolve_arguments"]
