"""The protocol: what a scientist writes, as data.

Values that may hold an expression `${{ ... }}` are kept as written; `engine` gives them meaning.
"""

from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, StringConstraints, ValidationInfo, field_validator
from pydantic.json_schema import models_json_schema
from pydantic_core import PydanticCustomError, core_schema
from typing_extensions import TypeAliasType

from .model import Model, no_items

Scalar = str | int | float | bool | None
Duration = str | int | float
Count = int | str
StepId = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
Role = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=60)]
ContractName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*@[0-9]+$")]
RoleAction = Annotated[
    str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*$")
]


class Param(Model):
    """One parameter of a protocol, set by `-p`, by the web form or by a caller."""

    type: Literal["quantity", "number", "integer", "string", "boolean", "array"]
    unit: str | None = None
    summary: str = ""
    default: Any = None
    minimum: Scalar = None
    maximum: Scalar = None
    pattern: str | None = None
    enum: list[Any] | None = Field(default=None, min_length=1)
    items: dict[str, Any] | None = None


class Defaults(Model):
    """Defaults for steps that do not set their own."""

    timeout: Duration | None = None
    retry: "int | Retry | None" = None
    background: int = Field(default=1, ge=1, le=1000)


class Retry(Model):
    """How often (in total) and when a failed step is tried."""

    attempts: int = Field(ge=1, le=1000)
    wait: Duration = 0
    factor: float = Field(default=1.0, ge=1.0, le=100.0)
    max_wait: Duration | None = None
    jitter: float = Field(default=0.0, ge=0.0, le=1.0)
    on: list[str] | None = Field(default=None, min_length=1)


class KeepGoing(Model):
    """How many iterations of a loop may fail, in all and in a row, before it stops.

    `keep_going: true` is one without limits.
    """

    max_failed: int | str | None = None
    in_a_row: int | str | None = None


class StepBase(Model):
    """The keys that any step may have."""

    KIND: ClassVar[str]

    id: StepId | None = None
    name: str | None = None
    when: Scalar = None
    timeout: Duration | None = None
    retry: int | Retry | None = None
    fallback: "list[Step | list[Step]]" = Field(default_factory=no_items, min_length=1)
    on_error: Literal["stop", "continue", "pause"] | None = None
    on_unknown: Literal["probe", "ask", "skip", "repeat"] | None = None


class Do(StepBase):
    """One action on one device: an action set of one."""

    KIND: ClassVar[str] = "do"
    do: RoleAction
    with_: dict[str, Any] = Field(default_factory=dict, alias="with")
    mode: Literal["background"] | None = None


class Parallel(StepBase):
    """An action set: its members start together, and it ends when all have ended."""

    KIND: ClassVar[str] = "parallel"
    parallel: "list[Step]" = Field(min_length=1)
    on_failure: Literal["finish", "cancel"] | None = None


class AnyOf(StepBase):
    """An action set that ends with the first member that succeeds; the others are cancelled."""

    KIND: ClassVar[str] = "any"
    any: "list[Step]" = Field(min_length=1)


class LoopBase(StepBase):
    """The keys that every loop may have."""

    steps: "list[Step]" = Field(min_length=1)
    keep_going: KeepGoing | None = None
    collect: dict[str, Any] | None = None

    @field_validator("keep_going", mode="before")
    @classmethod
    def _without_limits(cls, given: Any) -> Any:
        return KeepGoing() if given is True else given


class Foreach(LoopBase):
    """The same steps for each item of a list, a span or a grid."""

    KIND: ClassVar[str] = "foreach"
    foreach: dict[Role, Any] = Field(min_length=1, max_length=1)
    key: Scalar = None
    at_once: Count | None = None
    order: Literal["listed", "shortest"] | None = None

    @field_validator("order")
    @classmethod
    def _of_several(cls, given: str | None, info: ValidationInfo) -> str | None:
        if given == "shortest" and info.data.get("at_once") is None:
            raise ValueError(
                "one iteration after the other takes as long in any order: it goes with `at_once`"
            )
        return given


class Repeat(LoopBase):
    """The same steps a given number of times."""

    KIND: ClassVar[str] = "repeat"
    repeat: Count


class While(LoopBase):
    """The same steps as long as an expression is true, `max` times at most."""

    KIND: ClassVar[str] = "while"
    while_: Scalar = Field(alias="while")
    max: Count | None = None


class If(StepBase):
    """One of two lists of steps."""

    KIND: ClassVar[str] = "if"
    if_: Scalar = Field(alias="if")
    then: "list[Step]" = Field(min_length=1)
    else_: "list[Step] | None" = Field(default=None, alias="else", min_length=1)


class Use(StepBase):
    """The steps of another protocol; `devices` maps its roles to roles of this one."""

    KIND: ClassVar[str] = "use"
    use: str = Field(min_length=1)
    with_: dict[str, Any] = Field(default_factory=dict, alias="with")
    devices: dict[Role, Role] = Field(default_factory=dict)


class Watch(Model):
    """What is looked at while the steps of a group run, and what happens when it is so.

    `do` reads a device each time, and `steps.ID` of its `id` is what it read. A `then` that only tells
    (`notify`, `log`) and `pause` leave the steps running; any other takes their place.
    """

    when: Scalar
    then: "Step | list[Step] | Literal['pause']"
    name: str | None = None
    every: Duration | None = None
    id: StepId | None = None
    do: RoleAction | None = None
    with_: dict[str, Any] = Field(default_factory=dict, alias="with")
    stale: Duration | None = None
    on_stale: Literal["then", "ignore"] | None = None

    @field_validator("then", mode="before")
    @classmethod
    def _steps_or_pause(cls, given: Any) -> Any:
        if isinstance(given, dict | list | StepBase) or given == "pause":
            return given
        raise ValueError("it is a step such as {fail: it leaks}, a list of steps, or pause")

    @property
    def steps(self) -> "list[Step]":
        """What happens then; nothing for a pause."""
        if self.then == "pause":
            return []
        return self.then if isinstance(self.then, list) else [self.then]  # type: ignore[list-item]

    @property
    def leaves_running(self) -> bool:
        """Whether the steps of the group go on: a pause, or nothing but words."""
        return all(isinstance(step, Notify | Log) for step in self.steps)


class Group(StepBase):
    """Steps one after the other, watched, with devices of their own, or beside the steps that follow."""

    KIND: ClassVar[str] = "steps"
    steps: "list[Step]" = Field(min_length=1)
    watch: list[Watch] = Field(default_factory=no_items, min_length=1)
    reserve: list[Role] = Field(default_factory=no_items, min_length=1)
    mode: Literal["background"] | None = None


CONFIRM_CHOICES = ["yes", "no"]


class Confirm(StepBase):
    """A person must confirm before the run continues."""

    KIND: ClassVar[str] = "confirm"
    confirm: str


class Ask(StepBase):
    """A person chooses; the result is `{choice}`."""

    KIND: ClassVar[str] = "ask"
    ask: str
    choices: list[str] = Field(min_length=1)


class Until(Model):
    """A time of day, a date with its time, or an expression that gives a moment."""

    until: str


class Wait(StepBase):
    """Wait for a given time, or until a time of day."""

    KIND: ClassVar[str] = "wait"
    wait: Duration | Until

    @field_validator("wait", mode="before")
    @classmethod
    def _time_or_until(cls, given: Any) -> Any:
        if isinstance(given, dict) and "until" not in given:
            raise ValueError('it is a time such as 30 s, or {until: "07:00"}')
        return given

    @property
    def until(self) -> str | None:
        """The time of day that it waits for; None where it waits for a given time."""
        return self.wait.until if isinstance(self.wait, Until) else None


class Set(StepBase):
    """Names for values, used by the steps that follow."""

    KIND: ClassVar[str] = "set"
    set: dict[Role, Any] = Field(min_length=1)


class Require(StepBase):
    """The run fails here unless the expression is true."""

    KIND: ClassVar[str] = "require"
    require: Scalar


class Log(StepBase):
    """A line for the screen and the journal."""

    KIND: ClassVar[str] = "log"
    log: str


class Notify(StepBase):
    """A message to the people whom the lab's `notify` names, with a picture of the run if wanted."""

    KIND: ClassVar[str] = "notify"
    notify: str
    picture: str | None = None


class Fail(StepBase):
    """The step fails, with this message."""

    KIND: ClassVar[str] = "fail"
    fail: str


STEP_KINDS: tuple[type[StepBase], ...] = (
    Do, Parallel, AnyOf, Foreach, Repeat, While, If, Use, Group,
    Confirm, Ask, Wait, Set, Require, Log, Notify, Fail,
)  # fmt: skip


def step_kind(value: Any) -> str | None:
    """The kind of step that a mapping is, by its first keyword; None if it is not a step."""
    if isinstance(value, StepBase):
        return value.KIND
    if isinstance(value, dict):
        for kind in STEP_KINDS:
            if kind.KIND in value:
                return kind.KIND
    return None


FINALLY_S = 600.0
"""How long `finally` may take, beside the timeouts and waits that its steps state."""

STEP_LISTS = {
    "steps": "steps", "parallel": "parallel", "any": "any", "then": "then", "else": "else_",
}  # fmt: skip
"""The keys under which a step contains steps -> the names of their fields."""


def inner_lists(step: StepBase) -> Iterator[tuple[str, "list[Step]"]]:
    """The lists of steps that a step contains, each with its YAML key; without its fallbacks."""
    for key, name in _list_fields(type(step)):
        steps = getattr(step, name)
        if steps:
            yield key, steps


def watches(step: StepBase) -> "list[Watch]":
    """What is watched while the steps of a group run."""
    return step.watch or [] if isinstance(step, Group) else []


def thens(step: StepBase) -> "Iterator[tuple[Step | list[Step], tuple[str, int, str]]]":
    """What happens when a watch of this group is right, a step or a list, with its keys in YAML."""
    for index, watch in enumerate(watches(step)):
        if watch.then != "pause":
            yield watch.then, ("watch", index, "then")  # type: ignore[misc]


@cache
def _list_fields(kind: type[StepBase]) -> list[tuple[str, str]]:
    return [(key, name) for key, name in STEP_LISTS.items() if name in kind.model_fields]


@cache
def _kinds() -> dict[str, type[StepBase]]:
    return {kind.KIND: kind for kind in STEP_KINDS}


def _read_step(value: Any) -> StepBase:
    if isinstance(value, StepBase):
        return value
    kind = step_kind(value)
    if kind is None:
        raise PydanticCustomError("step", "a step is a mapping with a keyword")
    return _kinds()[kind].model_validate(value)


class EachByItsKind:
    """A step is read by the model of its kind, whose validator is built when one is met.

    Those of all kinds would take longer to build than everything else of a protocol.
    """

    @staticmethod
    def __get_pydantic_core_schema__(source: Any, handler: Any) -> Any:
        return core_schema.no_info_plain_validator_function(_read_step)

    @staticmethod
    def __get_pydantic_json_schema__(schema: Any, handler: Any) -> dict[str, Any]:
        return {}


def protocol_as_json_schema() -> dict[str, Any]:
    """The JSON Schema of a protocol, with every kind of step among its `$defs`."""
    models = [(model, "validation") for model in (Protocol, *STEP_KINDS)]
    _, made = models_json_schema(models, by_alias=True)  # pyright: ignore[reportArgumentType]
    defs = made["$defs"]
    protocol = defs.pop("Protocol")
    defs["Step"] = {"oneOf": [{"$ref": f"#/$defs/{kind.__name__}"} for kind in STEP_KINDS]}
    return {"$defs": dict(sorted(defs.items())), **protocol}


Step = TypeAliasType(
    "Step",
    Annotated[
        Do | Parallel | AnyOf | Foreach | Repeat | While | If | Use | Group | Confirm | Ask | Wait | Set
        | Require | Log | Notify | Fail,
        EachByItsKind,
    ],
)  # fmt: skip


class Protocol(Model):
    """P = [A1, ..., AT]: a sequence of sets of actions, and what surrounds it."""

    labrun: Literal[1]
    name: Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.-]*$", max_length=80)]
    summary: str = ""
    params: dict[Role, Param] = Field(default_factory=dict)
    devices: dict[Role, ContractName] = Field(default_factory=dict)
    functions: dict[Role, str] = Field(default_factory=dict)
    defaults: Defaults = Field(default_factory=Defaults)
    steps: list[Step] = Field(min_length=1)
    on_resume: list[Step] = Field(default_factory=no_items)
    finally_: list[Step] = Field(default_factory=no_items, alias="finally")
    outputs: dict[Role, Any] = Field(default_factory=dict)
