"""Interfaces that belong to no contract: running a protocol, and the messages of ROS itself."""

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
        text("protocol", "A file in the folder of protocols, or the name of one that ships"),
        free("params", 'Parameter -> value, such as {"pitch": "200 um"}'),
        free("bind", "Role -> device, where it has to be said"),
        free("answers", "Question -> choice, answered beforehand"),
    ))  # fmt: skip
    result = Message(package, "RunProtocolResult", with_errors((
        text("run", "The name of the run's folder"),
        text("fate", "succeeded, failed or aborted"),
        Field("holes", "int64", "holes", comment="Iterations that failed and were tolerated"),
        free("outputs", "What the protocol's `outputs` came to"),
    )))  # fmt: skip
    feedback = Message(package, "RunProtocolFeedback", (
        Field("progress", "float64", "progress", comment="0..1; NaN while nobody can say"),
        text("message", "What runs now"),
        text("run", "The name of the run's folder"),
        text("phase", "main, finally:n or resume:n"),
        Field("done", "int64", "done", comment="Iterations of the outermost loop that have ended"),
        Field("total", "int64", "total", comment="Of so many; 0 where the run will tell"),
    ))  # fmt: skip
    return ActionKind(
        package, "RunProtocol", goal, result, feedback,
        "Run a protocol: checked, journaled, and left behind as a folder that explains itself",
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
