"""Interfaces outside the contracts: running a protocol, and ROS's own messages."""

from .kinds import ActionKind, Field, Message, ServiceKind
from .of_contract import with_errors


def text(name: str, comment: str = "") -> Field:
    """A field of text."""
    return Field(name, "string", name, comment=comment)


def free(name: str, comment: str) -> Field:
    """A field of JSON text."""
    return Field(f"{name}_json", "string", name, json=True, comment=f"{comment}; as JSON text")


def run_protocol(package: str) -> ActionKind:
    """`/labrun/run_protocol`."""
    goal = Message(package, "RunProtocolGoal", (
        text("protocol", "A file in the folder of protocols, or the name of a shipped one"),
        free("params", 'Parameter -> value, such as {"pitch": "200 um"}'),
        free("bind", "Role -> device, where it is ambiguous"),
        free("answers", "Question -> choice, answered in advance"),
    ))  # fmt: skip
    result = Message(package, "RunProtocolResult", with_errors((
        text("run", "The name of the run's folder"),
        text("fate", "succeeded, failed or aborted"),
        Field("holes", "int64", "holes", comment="Iterations that failed and were tolerated"),
        free("outputs", "The values of the protocol's `outputs`"),
    )))  # fmt: skip
    feedback = Message(package, "RunProtocolFeedback", (
        Field("progress", "float64", "progress", comment="0..1; NaN while unknown"),
        text("message", "What is running now"),
        text("run", "The name of the run's folder"),
        text("phase", "main, finally:n or resume:n"),
        Field("done", "int64", "done", comment="Iterations of the outermost loop that have ended"),
        Field("total", "int64", "total", comment="Their total; 0 if known only during the run"),
    ))  # fmt: skip
    return ActionKind(
        package, "RunProtocol", goal, result, feedback,
        "Run a protocol: checked, journaled, and kept as a self-explanatory folder",
    )  # fmt: skip


def _numbers(name: str, type: str) -> Field:
    return Field(name, type, name)


UUID = Message("unique_identifier_msgs", "UUID", (Field("uuid", "uint8", "uuid", array="[16]"),))
TIME = Message(
    "builtin_interfaces", "Time", (_numbers("sec", "int32"), _numbers("nanosec", "uint32"))
)
GOAL_INFO = Message("action_msgs", "GoalInfo", (
    Field("goal_id", "UUID", "goal_id", message=UUID), Field("stamp", "Time", "stamp", message=TIME),
))  # fmt: skip
GOAL_STATUS = Message("action_msgs", "GoalStatus", (
    Field("goal_info", "GoalInfo", "goal_info", message=GOAL_INFO), _numbers("status", "int8"),
))  # fmt: skip
GOAL_STATUS_ARRAY = Message("action_msgs", "GoalStatusArray", (
    Field("status_list", "GoalStatus", "status_list", array="[]", message=GOAL_STATUS),
))  # fmt: skip
CANCEL_GOAL = ServiceKind(
    "action_msgs", "CancelGoal",
    Message("action_msgs", "CancelGoalRequest", (
        Field("goal_info", "GoalInfo", "goal_info", message=GOAL_INFO),
    )),
    Message("action_msgs", "CancelGoalResponse", (
        _numbers("return_code", "int8"),
        Field("goals_canceling", "GoalInfo", "goals_canceling", array="[]", message=GOAL_INFO),
    )),
)  # fmt: skip
STRING = Message("std_msgs", "String", (text("data"),))
