"""The ROS interfaces of a contract: its actions, a service for each pure one, one status message."""

from collections.abc import Iterable
from dataclasses import dataclass

from ....schemas.contract import Action, Contract
from .from_schema import message_of
from .kinds import ActionKind, Field, Message, ServiceKind
from .names import field_name, type_name

ERROR = (
    ("error_name", "Empty on success; else an error of the contract, or Timeout, Busy, Lost, Stopped"),
    ("error_message", "What went wrong"),
    ("error_happened", "Whether the action took effect nevertheless: yes, no or unknown"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ContractKinds:
    """One contract in ROS; `services` for pure actions only."""

    status: Message
    actions: dict[str, ActionKind]
    services: dict[str, ServiceKind]


def kinds_of(contract: Contract, package: str) -> ContractKinds:
    """The interfaces of one contract."""
    actions, services = {}, {}
    for name, action in contract.actions.items():
        actions[name] = _action(contract.type, name, action, package)
        if action.effect == "pure":
            services[name] = _service(actions[name])
    status = message_of(
        contract.status, package, type_name(contract.type, "status"),
        summary=f"The status of a {contract.type}: {contract.summary}",
    )  # fmt: skip
    return ContractKinds(status, actions, services)


def _action(contract: str, name: str, action: Action, package: str) -> ActionKind:
    own = type_name(contract, name)
    goal = message_of(action.params, package, f"{own}Goal", sent=True)
    returned = message_of(action.returns, package, f"{own}Result")
    result = Message(package, f"{own}Result", with_errors(returned.fields))
    feedback = feedback_message(package, f"{own}Feedback")
    return ActionKind(package, own, goal, result, feedback, _summary(contract, name, action))


def _service(kind: ActionKind) -> ServiceKind:
    request = Message(kind.package, f"{kind.name}Request", kind.goal.fields)
    response = Message(kind.package, f"{kind.name}Response", kind.result.fields)
    return ServiceKind(kind.package, kind.name, request, response, kind.summary)


def with_errors(fields: Iterable[Field]) -> tuple[Field, ...]:
    """The fields of a result, followed by those that explain a missing one."""
    all_fields = list(fields)
    for key, words in ERROR:
        name = field_name(key, [field.name for field in all_fields])
        all_fields.append(Field(name, "string", key=f"@{key}", comment=words))
    return tuple(all_fields)


def feedback_message(package: str, name: str) -> Message:
    """Progress of a goal."""
    progress = Field("progress", "float64", "progress", comment="0..1; NaN while unknown")
    return Message(package, name, (progress, Field("message", "string", "message")))


def _summary(contract: str, name: str, action: Action) -> str:
    parts = [f"{contract} {name}", action.summary, f"effect: {action.effect}"]
    parts += [f"danger: {action.danger}"] if action.danger else []
    parts += [f"takes about {action.duration}"] if action.duration else []
    parts += ["" if action.cancel else "cannot be cancelled"]
    parts += [f"errors: {', '.join(action.errors)}"] if action.errors else []
    return "\n".join(part for part in parts if part)
