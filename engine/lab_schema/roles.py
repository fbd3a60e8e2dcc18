"""What a lab adds to the language: its devices, their actions and the parameters of each.

The protocol names the roles, so a lab only knows roles with a device's name. For each of its
devices one shape applies to all steps: its actions where the protocol declares the role with the
same contract, none where it does not. The shapes are chosen at the top of the file, by the entries
under `devices`.
"""

from collections import Counter

from ...schemas.contract import Contract
from ..lab.lab import LoadedLab
from .arguments import is_needed, with_shape
from .devices import devices_shape, kept_contracts
from .downward import down, everywhere, given
from .values import Shape


def role_shapes(lab: LoadedLab) -> dict[str, Shape]:
    """Name -> shape of `devices`, of every `with`, and of the steps for every device."""
    shapes: dict[str, Shape] = {"devices": devices_shape(lab)}
    for name, device in lab.lab.devices.items():
        contract = lab.contracts[device.contract]
        for action_name, action in contract.actions.items():
            label = f"{name}.{action_name}"
            shapes[f"with-{label}"] = with_shape(label, action, device.limits)
        shapes |= _role(name, contract) | _no_role(name, device.contract)
    return {**shapes, **_only_known(lab), **_other_names(lab)}


def role_rules(lab: LoadedLab) -> list[Shape]:
    """Which of these shapes apply, by the entries under `devices`."""
    rules: list[Shape] = []
    for name, device in lab.lab.devices.items():
        so = {
            "properties": {name: {"enum": [device.contract, *lab.contracts[device.contract].also]}},
            "required": [name],
        }
        rules.append({"if": _declared(so), "then": everywhere(f"role-{name}")})
        rules.append({"if": _declared({"required": [name]}), "else": everywhere(f"no-role-{name}")})
    known = {"propertyNames": {"enum": list(lab.lab.devices)}}
    rules.append({
        "if": {"properties": {"devices": known}},
        "then": everywhere("roles-of-the-lab"),
        "else": everywhere("roles-of-other-names"),
    })  # fmt: skip
    return rules


def _declared(so: Shape) -> Shape:
    return {
        "type": "object",
        "required": ["devices"],
        "properties": {"devices": {"type": "object", **so}},
    }


def _role(name: str, contract: Contract) -> dict[str, Shape]:
    actions = contract.actions
    says = f"{name} has no such action; it has {', '.join(actions)}."
    do: Shape = {
        "anyOf": [
            {
                "enum": [f"{name}.{action}" for action in actions],
                "enumDescriptions": [action.summary for action in actions.values()],
                "errorMessage": says,
            },
            {"pattern": f"^(?!{name}\\.)", "patternErrorMessage": says},
        ]
    }
    rules = [
        given(
            {"const": f"{name}.{action_name}"},
            f"{name}.{action_name}",
            f"with-{name}.{action_name}",
            needed=is_needed(action),
        )
        for action_name, action in actions.items()
    ]
    return down(f"role-{name}", do, *rules)


def _no_role(name: str, contract: str) -> dict[str, Shape]:
    says = f"The protocol declares no role {name}: add `devices: {{{name}: {contract}}}`."
    return down(f"no-role-{name}", {"pattern": f"^(?!{name}\\.)", "patternErrorMessage": says})


def _only_known(lab: LoadedLab) -> dict[str, Shape]:
    devices = list(lab.lab.devices)
    says = f"There is no such role; the lab's devices are {', '.join(devices)}."
    return down(
        "roles-of-the-lab",
        {"pattern": f"^(?:{'|'.join(devices)})\\.", "patternErrorMessage": says},
    )


def _other_names(lab: LoadedLab) -> dict[str, Shape]:
    """Roles not named after a device: any action of the lab, checked if only one contract has it."""
    contracts = kept_contracts(lab)
    count = Counter(name for contract in contracts.values() for name in contract.actions)
    other = f"^(?!(?:{'|'.join(lab.lab.devices)})\\.)"
    says = f"No device of this lab has that action; there are {', '.join(sorted(count))}."
    do: Shape = {
        "if": {"pattern": other},
        "then": {"pattern": f"\\.(?:{'|'.join(sorted(count))})$", "patternErrorMessage": says},
    }
    rules: list[Shape] = []
    shapes: dict[str, Shape] = {}
    for type_, contract in contracts.items():
        keeping = [name for name, device in lab.lab.devices.items() if device.contract == type_]
        for name, action in contract.actions.items():
            if count[name] > 1:
                continue
            if len(keeping) == 1:  # whatever the role is called, this device plays it
                shape = f"with-{keeping[0]}.{name}"
            else:
                shape = f"with-{type_.replace('@', '-')}.{name}"
                shapes[shape] = with_shape(name, action, {})
            test = {"pattern": f"{other}.*\\.{name}$"}
            rules.append(given(test, name, shape, needed=is_needed(action)))
    return {**shapes, **down("roles-of-other-names", do, *rules)}
