"""The driver's `config:` in a lab, read and checked against the contract.

bridge: ws://10.0.0.9:9090        # a rosbridge; or `node: true`, where ROS is installed
actions:
  move_to:
    action: /arm/move             # the ROS action and its type
    type: arm_msgs/action/Move
    goal: {x: {field: target.x, unit: m}}      # the field of each parameter; its own name by default
    result: {x: final.x}                       # the field of each result
    constants: {frame: bench}                  # fields that are always the same
    aborted: Stuck                             # the contract's error for an aborted goal
status: {topic: /arm/state, type: arm_msgs/msg/State, fields: {x: pose.x}}
"""

from dataclasses import dataclass, field
from typing import Any

from ...schemas.contract import Action, Contract
from .spots import Spot, read_spots

KEYS = ("bridge", "node", "actions", "status")
ACTION_KEYS = ("action", "type", "goal", "result", "constants", "aborted")
STATUS_KEYS = ("topic", "type", "fields")


@dataclass(frozen=True, slots=True)
class RosGoal:
    """How one action of the contract maps to one of ROS."""

    action: str
    type: str
    goal: dict[str, Spot]
    result: dict[str, Spot]
    constants: dict[str, Any]
    aborted: str


@dataclass(frozen=True, slots=True)
class RosStatus:
    """The topic from which the status is read."""

    topic: str
    type: str
    fields: dict[str, Spot]


@dataclass(frozen=True, slots=True)
class Config:
    """The whole configuration; `bridge` is None if the driver is a node itself."""

    bridge: str | None
    actions: dict[str, RosGoal]
    status: RosStatus | None = None
    errors: dict[str, tuple[str, ...]] = field(default_factory=dict)


def read_config(written: dict[str, Any], contract: Contract) -> Config:
    """Read the configuration; raises ValueError with the first error."""
    _known(written, KEYS, "config")
    bridge, node = written.get("bridge"), written.get("node", False)
    if (bridge is None) == (node is not True):
        raise ValueError("give either `bridge: ws://HOST:PORT` or `node: true`")
    if bridge is not None and not str(bridge).startswith(("ws://", "wss://")):
        raise ValueError(
            f"bridge: {bridge!r} is not the address of a rosbridge, such as ws://10.0.0.9:9090"
        )
    given = _object(written.get("actions"), "actions")
    _known(given, tuple(contract.actions), "actions")
    missing = [name for name in contract.actions if name not in given]
    if missing:
        raise ValueError(f"actions: {missing[0]} of {contract.type} has no ROS action")
    actions = {
        name: _action(given[name], one, f"actions.{name}") for name, one in contract.actions.items()
    }
    errors = {name: tuple(one.errors) for name, one in contract.actions.items()}
    return Config(bridge, actions, _status(written.get("status"), contract), errors)


def _action(written: Any, action: Action, where: str) -> RosGoal:
    given = _object(written, where)
    _known(given, ACTION_KEYS, where)
    aborted = given.get("aborted", "Aborted")
    if "aborted" in given and aborted not in action.errors:
        known = ", ".join(action.errors) or "none"
        raise ValueError(
            f"{where}.aborted: {aborted} is not an error of the contract; its errors are {known}"
        )
    returned = action.returns.get("properties", {})
    return RosGoal(
        _text(given, "action", where), _text(given, "type", where),
        read_spots(given.get("goal"), action.param_schemas(), f"{where}.goal"),
        read_spots(given.get("result"), returned, f"{where}.result"),
        _object(given.get("constants", {}), f"{where}.constants"), aborted,
    )  # fmt: skip


def _status(written: Any, contract: Contract) -> RosStatus | None:
    if written is None:
        return None
    given = _object(written, "status")
    _known(given, STATUS_KEYS, "status")
    schemas = contract.status.get("properties", {})
    fields = read_spots(given.get("fields"), schemas, "status.fields")
    return RosStatus(_text(given, "topic", "status"), _text(given, "type", "status"), fields)


def _object(written: Any, where: str) -> dict[str, Any]:
    if not isinstance(written, dict):
        raise ValueError(f"{where} must be a mapping of names, not {written!r}")
    return written


def _text(given: dict[str, Any], name: str, where: str) -> str:
    value = given.get(name)
    if not isinstance(value, str) or not value:
        raise ValueError(f"{where} needs `{name}`, such as /arm/move or arm_msgs/action/Move")
    return value


def _known(given: dict[str, Any], names: tuple[str, ...], where: str) -> None:
    strange = [name for name in given if name not in names]
    if strange:
        raise ValueError(f"{where}: unknown key {strange[0]!r}; the keys are {', '.join(names)}")
