"""Which device of the lab plays which role of the protocol."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ...schemas.contract import Contract
from ...schemas.lab import Limit
from ...schemas.problem import Problem
from ..language.source import Source
from ..language.suggest import did_you_mean, listed
from .lab import LoadedLab

CODES = {
    "E208": "a contract that is not known",
    "E209": "a role that no device, or more than one, can play",
    "E210": "a `--bind` that does not fit",
}


@dataclass(frozen=True)
class BoundRole:
    """A role with the device that plays it and that device's contract."""

    role: str
    device: str
    contract: Contract
    limits: dict[str, Limit] = field(default_factory=dict)


def bind_roles(
    devices: Mapping[str, str], lab: LoadedLab, bind: Mapping[str, str], source: Source
) -> tuple[dict[str, BoundRole], list[Problem]]:
    """Role -> device: by `--bind`, by the role's name, or the only device with the contract.

    Of several simulated devices the first free one is taken; of real ones a person must choose.
    """
    roles: dict[str, BoundRole] = {}
    problems = list(_unknown_binds(devices, bind))
    for role, contract in devices.items():
        taken = {one.device for one in roles.values()} | {*devices} | {*bind.values()}
        found = _device(role, contract, lab, bind, source, taken)
        if isinstance(found, Problem):
            problems.append(found)
        elif found is not None:
            device = lab.lab.devices[found]
            roles[role] = BoundRole(role, found, lab.contracts[contract], dict(device.limits))
    return roles, problems


def _unknown_binds(devices: Mapping[str, str], bind: Mapping[str, str]) -> Iterator[Problem]:
    for role in bind:
        if role not in devices:
            yield Problem(
                file="--bind", line=1, column=1, code="E210",
                message=f"the protocol has no role {role}{did_you_mean(role, devices)}",
                hint=f"its roles: {listed(devices)}",
            )  # fmt: skip


def _device(
    role: str, contract: str, lab: LoadedLab, bind: Mapping[str, str], source: Source,
    taken: set[str],
) -> str | Problem | None:  # fmt: skip
    if contract not in lab.contracts:
        return _no_contract(role, contract, lab, source)
    fitting = lab.keeping(contract)
    if role in bind:
        return _bound(role, contract, lab, bind[role], fitting)
    if role in fitting:
        return role
    if len(fitting) == 1:
        return fitting[0]
    if fitting and lab.lab.simulated:
        return next((name for name in fitting if name not in taken), fitting[0])
    where = f"the lab {lab.lab.name!r}"
    if not fitting:
        message = f"{where} has no {contract} device for the role {role}"
        hint = "its devices: " + listed(f"{n} ({d.contract})" for n, d in lab.lab.devices.items())
    else:
        message = f"{len(fitting)} devices of {where} could play the role {role}"
        hint = f"choose one: --bind {role}={fitting[0]} (or {listed(fitting[1:])})"
    return source.problem(("devices", role), "E209", message, hint)


def _no_contract(role: str, contract: str, lab: LoadedLab, source: Source) -> Problem:
    name, _, major = contract.partition("@")
    others = [known for known in lab.contracts if known.partition("@")[0] == name]
    if others:
        message = f"there is no version {major} of the contract {name}; there is {listed(others)}"
    else:
        message = f"there is no contract {contract}{did_you_mean(contract, lab.contracts)}"
    return source.problem(("devices", role), "E208", message, f"known: {listed(lab.contracts)}")


def _bound(
    role: str, contract: str, lab: LoadedLab, device: str, fitting: list[str]
) -> str | Problem:
    if device in fitting:
        return device
    hint = f"{contract} devices: {listed(fitting)}"
    if device in lab.lab.devices:
        message = f"{device} is a {lab.lab.devices[device].contract}, but the role {role} needs a {contract}"
    else:
        guess = did_you_mean(device, lab.lab.devices)
        message = f"the lab {lab.lab.name!r} has no device {device}{guess}"
    return Problem(file="--bind", line=1, column=1, code="E210", message=message, hint=hint)
