"""The driver's `config:` in a lab, read and checked against the contract.

bridge: ws://10.0.0.9:9090        # a rosbridge; or `node: true`, where ROS is installed
actions:
  move_to:
    action: /arm/move             # the ROS action and its type; or `service: /arm/stop`
    type: arm_msgs/action/Move
    goal: {x: {field: target.x, unit: m}}      # the field of each parameter; its own name by default
    result: {x: final.x}                       # the field of each result
    constants: {frame: bench}                  # fields that are always the same
    feedback: {message: "{distance:.1f} m"}    # see `answers.py`
    error: {code: error_code, names: {-4: Stuck}}
    aborted: Stuck                             # the contract's error for any other failure
  stop: {service: /arm/stop, type: std_srvs/srv/Trigger, answer_s: 5}
status:                           # one topic, or a list of them
  topic: /arm/state
  type: arm_msgs/msg/State
  fields: {x: pose.x}
  qos: {reliability: best_effort}
  silent_s: 3                     # so long may it be silent before the robot counts as gone
gone_s: 3                         # so long may an action server be missing before its goals are lost
"""

from dataclasses import dataclass, field
from typing import Any

from ...schemas.contract import Action, Contract
from ..driver import Driver, check_keys
from .answers import SERVICE, Failure, Feedback, read_failure, read_feedback
from .spots import Spot, read_spots

KEYS = ("bridge", "node", "actions", "status", "gone_s")
ACTION_KEYS = (
    "action", "service", "type", "goal", "result", "constants", "feedback", "error", "aborted", "answer_s",
)  # fmt: skip
STATUS_KEYS = ("topic", "type", "fields", "qos", "silent_s")
QOS = {
    "reliability": ("reliable", "best_effort"), "durability": ("volatile", "transient_local"),
}  # fmt: skip
GONE_S, ANSWER_S = 3.0, 30.0


@dataclass(frozen=True, slots=True)
class RosGoal:
    """How one action of the contract maps to an action of ROS, or to a service."""

    action: str
    type: str
    goal: dict[str, Spot]
    result: dict[str, Spot]
    constants: dict[str, Any]
    aborted: str
    feedback: Feedback = field(default_factory=Feedback)
    failure: Failure = field(default_factory=Failure)
    is_service: bool = False
    answer_s: float = ANSWER_S


@dataclass(frozen=True, slots=True)
class RosStatus:
    """A topic from which the status is read; `silent_s`: so long may it be silent."""

    topic: str
    type: str
    fields: dict[str, Spot]
    qos: dict[str, Any] = field(default_factory=dict)
    silent_s: float | None = None


@dataclass(frozen=True, slots=True)
class Config:
    """The whole configuration; `bridge` is None if the driver is a node itself."""

    bridge: str | None
    actions: dict[str, RosGoal]
    status: tuple[RosStatus, ...] = ()
    gone_s: float = GONE_S
    errors: dict[str, tuple[str, ...]] = field(default_factory=dict)


def read_config(written: dict[str, Any], contract: Contract) -> Config:
    """Read the configuration; raises ValueError with the first error."""
    check_keys(KEYS, written)
    bridge, node = written.get("bridge"), written.get("node", False)
    if (bridge is None) == (node is not True):
        raise ValueError("give either `bridge: ws://HOST:PORT` or `node: true`")
    if bridge is not None and not str(bridge).startswith(("ws://", "wss://")):
        raise ValueError(
            f"bridge: {bridge!r} is not the address of a rosbridge, such as ws://10.0.0.9:9090"
        )
    taken = [name for name in contract.actions if hasattr(Driver, name)]
    if taken:
        raise ValueError(
            f"{contract.type}: an action cannot be named {taken[0]}, which every driver has; rename it"
        )
    given = _object(written.get("actions"), "actions")
    check_keys(tuple(contract.actions), given, "actions")
    missing = [name for name in contract.actions if name not in given]
    if missing:
        raise ValueError(f"actions: {missing[0]} of {contract.type} has no ROS action")
    actions = {
        name: _action(given[name], one, f"actions.{name}") for name, one in contract.actions.items()
    }
    errors = {name: tuple(one.errors) for name, one in contract.actions.items()}
    topics = written.get("status") or []
    topics = topics if isinstance(topics, list) else [topics]
    status = tuple(_status(one, contract, len(topics) == 1, bridge) for one in topics)
    return Config(bridge, actions, status, _number(written, "gone_s", "config", GONE_S), errors)


def _action(written: Any, action: Action, where: str) -> RosGoal:
    given = _object(written, where)
    check_keys(ACTION_KEYS, given, where)
    aborted = given.get("aborted", "Aborted")
    if "aborted" in given and aborted not in action.errors:
        known = ", ".join(action.errors) or "none"
        raise ValueError(
            f"{where}.aborted: {aborted} is not an error of the contract; its errors are {known}"
        )
    if ("action" in given) == ("service" in given):
        raise ValueError(f"{where} needs `action` or `service`, such as /arm/move")
    is_service = "service" in given
    errors = action.errors
    returned = action.returns.get("properties", {})
    return RosGoal(
        _text(given, "service" if is_service else "action", where), _text(given, "type", where),
        read_spots(given.get("goal"), action.param_schemas(), f"{where}.goal"),
        read_spots(given.get("result"), returned, f"{where}.result"),
        _object(given.get("constants", {}), f"{where}.constants"), aborted,
        read_feedback(given.get("feedback"), f"{where}.feedback"),
        read_failure(
            given.get("error"), errors, SERVICE if is_service else Failure(), f"{where}.error"
        ),
        is_service, _number(given, "answer_s", where, ANSWER_S),
    )  # fmt: skip


def _status(written: Any, contract: Contract, is_all: bool, bridge: str | None) -> RosStatus:
    given = _object(written, "status")
    check_keys(STATUS_KEYS, given, "status")
    schemas = contract.status.get("properties", {})
    fields = given.get("fields")
    if not is_all and isinstance(fields, dict):  # of several topics each has its own; `{}` has none
        own = {name: schema for name, schema in schemas.items() if name in fields}
        schemas = own or (schemas if fields else {})
    qos = _object(given.get("qos", {}), "status.qos")
    if qos and bridge is not None:
        raise ValueError("status.qos is for `node: true`; a rosbridge takes that of the publisher")
    check_keys((*QOS, "depth"), qos, "status.qos")
    for name, words in QOS.items():
        if name in qos and qos[name] not in words:
            raise ValueError(f"status.qos.{name}: {qos[name]!r} is not one of {', '.join(words)}")
    depth = qos.get("depth", 1)
    if isinstance(depth, bool) or not isinstance(depth, int) or depth < 1:
        raise ValueError(f"status.qos.depth: {depth!r} is not a number of messages")
    silent_s = _number(given, "silent_s", "status", 0.0) if "silent_s" in given else None
    return RosStatus(
        _text(given, "topic", "status"), _text(given, "type", "status"),
        read_spots(fields, schemas, "status.fields"), qos, silent_s,
    )  # fmt: skip


def _number(given: dict[str, Any], name: str, where: str, default: float) -> float:
    value = given.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0:
        raise ValueError(f"{where}.{name}: {value!r} is not a number of seconds above 0")
    return float(value)


def _object(written: Any, where: str) -> dict[str, Any]:
    if not isinstance(written, dict):
        raise ValueError(f"{where} must be a mapping of names, not {written!r}")
    return written


def _text(given: dict[str, Any], name: str, where: str) -> str:
    value = given.get(name)
    if not isinstance(value, str) or not value:
        raise ValueError(f"{where} needs `{name}`, such as /arm/move or arm_msgs/action/Move")
    return value
