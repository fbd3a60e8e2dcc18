"""A used protocol gets everything it declares: its parameters by `with`, its devices by role.

E230. Each of its roles is filled by the role of the same name in this protocol, or by the one that
`devices: {its_role: our_role}` names; both must have the same contract.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 mm}, devices: {stage: gantry}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 mm}}
      - do: gantry.home

Beside it, lift.yaml:

    params: {height: {type: quantity, unit: mm, maximum: 100 mm}}
    devices: {stage: gantry@1}
    steps:
      - {do: stage.move_to, with: {z: "${{ params.height }}"}}

E231. `with` gives values to its parameters. A value for a parameter that it does not have would
have no effect.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 mm}, devices: {stage: gantry}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 mm, hight: 6 mm}, devices: {stage: gantry}}

Beside it, lift.yaml:

    params: {height: {type: quantity, unit: mm, maximum: 100 mm}}
    devices: {stage: gantry@1}
    steps:
      - {do: stage.move_to, with: {z: "${{ params.height }}"}}

E232. A parameter without a default gets its value from the protocol that uses it.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 mm}, devices: {stage: gantry}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, devices: {stage: gantry}}

Beside it, lift.yaml:

    params: {height: {type: quantity, unit: mm, maximum: 100 mm}}
    devices: {stage: gantry@1}
    steps:
      - {do: stage.move_to, with: {z: "${{ params.height }}"}}

E233. The value must have the parameter's type and dimension and be within its bounds, as on the
command line.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 mm}, devices: {stage: gantry}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {use: ./lift.yaml, with: {height: 5 s}, devices: {stage: gantry}}

Beside it, lift.yaml:

    params: {height: {type: quantity, unit: mm, maximum: 100 mm}}
    devices: {stage: gantry@1}
    steps:
      - {do: stage.move_to, with: {z: "${{ params.height }}"}}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Param
from ...schemas.quantity import same_dimension
from ..language.expression import ExpressionError
from ..language.fold import cases, fold
from ..language.shape import Place
from ..language.suggest import did_you_mean, listed
from ..language.types import Type, in_words, type_of_param
from ..language.value import Value
from ..params.params import ParamFault, given_value, take
from ..survey.spots import Spot
from ..survey.survey import Used
from .context import Context

CODES = {
    "E230": "a role of a used protocol without a matching role here",
    "E231": "a parameter that a used protocol does not have",
    "E232": "a parameter of a used protocol that has no value",
    "E233": "a value that does not fit the parameter of a used protocol",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `use` whose protocol could be read."""
    arguments = {at.place: at.arguments for at in context.survey.steps}
    for place, used in context.survey.used.items():
        yield from _roles(context, place, used)
        yield from _params(context, place, used, arguments[place])


def _roles(context: Context, place: Place, used: Used) -> Iterator[Problem]:
    wanted, declared = used.protocol.devices, context.source.names("devices")
    for its, ours in used.step.devices.items():
        at = (*place, "devices", its)
        if its not in wanted:
            message = f"{used.step.use} has no role {its}{did_you_mean(its, wanted)}"
            yield context.source.problem(at, "E230", message, f"it has {listed(wanted)}", key=True)
        elif ours not in declared:
            message = f"there is no role {ours}{did_you_mean(ours, declared)}"
            yield context.source.problem(at, "E230", message, f"roles: {listed(declared)}")
    for its, contract in wanted.items():
        ours = used.step.devices.get(its, its)
        bound = context.roles.get(ours)
        if ours not in declared and its not in used.step.devices:
            message = (
                f"{used.step.use} needs a {contract} for its role {its}, which is not declared here"
            )
            fitting = [role for role, one in context.roles.items() if one.contract.keeps(contract)]
            hint = f"choose a role for it: `devices: {{{its}: {(fitting or ['ROLE'])[0]}}}`"
            yield context.source.problem((*place, "use"), "E230", message, hint)
        elif bound is not None and not bound.contract.keeps(contract):
            wants = f"{used.step.use} needs a {contract} for its role {its}"
            message = f"{wants}; {ours} is a {bound.contract.type}"
            at = (*place, "devices", its) if its in used.step.devices else (*place, "use")
            fitting = [role for role, one in context.roles.items() if one.contract.keeps(contract)]
            hint = f"it can be {listed(fitting)}" if fitting else "no role here has that contract"
            yield context.source.problem(at, "E230", message, hint)


def _params(
    context: Context, place: Place, used: Used, arguments: dict[str, Spot]
) -> Iterator[Problem]:
    declared = used.protocol.params
    known = dict.fromkeys([*used.source.names("params"), *declared])
    for name, spot in arguments.items():
        at = (*place, "with", name)
        if name not in known:
            message = f"{used.step.use} has no parameter {name}{did_you_mean(name, known)}"
            hint = f"it has {listed(known)}" if known else "it has no `params`"
            yield context.source.problem(at, "E231", message, hint, key=True)
        elif name in declared:
            fault = _value_fault(name, declared[name], spot)
            if fault:
                yield context.source.problem(at, "E233", f"{name}: {fault}")
    for name, param in declared.items():
        if name not in arguments and param.default is None and context.whole:
            message = f"{used.step.use} needs a value for its parameter {name}"
            hint = f"add `with: {{{name}: ...}}`, or give it a `default`"
            yield context.source.problem((*place, "use"), "E232", message, hint)


def _value_fault(name: str, param: Param, spot: Spot) -> str:
    kind, faults = spot.inferred()
    value = spot.value
    if faults or not isinstance(value, Value):
        return ""
    folding = spot.env.folding()
    folded = fold(value, folding)
    if not folded.known:
        return _type_fault(kind, type_of_param(param))
    for case in cases(folded, folding, value):
        try:
            take(name, param, given_value(value.evaluate(case.names)), written=True)
        except ParamFault as fault:
            return f"{fault} (at {case.where})" if case.where else str(fault)
        except ExpressionError:
            return ""  # reported by the family `calculations`
    return ""


def _type_fault(kind: Type, wanted: Type) -> str:
    """Why a value that is not known yet cannot fit; empty where it may."""
    if kind.kind in ("any", "null", "text") or wanted.kind == "any":
        return ""
    if kind.kind != wanted.kind:
        return f"{in_words(kind)}, not {in_words(wanted)}"
    if kind.kind == "number" and kind.unit is not None:
        fits = wanted.unit is not None and same_dimension(kind.unit, wanted.unit)
        return "" if fits else f"{in_words(kind)}, not {in_words(wanted)}"
    return ""
