"""The steps of a protocol, and the places whose values may be computed."""

from dataclasses import dataclass, field
from typing import Any, Literal

from ...schemas.protocol import StepBase
from ..language.expression import ExpressionError
from ..language.infer import Fault, infer
from ..language.shape import Place
from ..language.types import ANY, TEXT, Type, either, type_of_value
from ..language.value import Computed, Constant, Fields, Items, Value, value_of
from .scope import Env

Use = Literal[
    "argument",
    "condition",
    "duration",
    "moment",
    "items",
    "key",
    "count",
    "text",
    "set",
    "collect",
    "output",
]


@dataclass(slots=True, eq=False)
class Spot:
    """One place with a value that may be computed."""

    place: Place
    raw: Any
    use: Use
    env: Env
    what: str = ""
    _value: Value | ExpressionError | None = None
    _inferred: tuple[Type, list[Fault]] | None = None

    @property
    def value(self) -> Value | ExpressionError:
        """The value, or why it cannot be read."""
        if self._value is None:
            try:
                self._value = value_of(self.raw, self.env.survey.own_names)
            except ExpressionError as fault:
                self._value = fault
        return self._value

    def inferred(self) -> tuple[Type, list[Fault]]:
        """The type of the value and the faults in its expressions."""
        if self._inferred is None:
            value = self.value
            self._inferred = (
                (ANY, [])
                if isinstance(value, ExpressionError)
                else type_and_faults(value, self.env)
            )
        return self._inferred


def type_and_faults(value: Value, env: Env) -> tuple[Type, list[Fault]]:
    """The type of a value, and the faults of all its expressions."""
    if isinstance(value, Computed):
        return infer(value.expression, env)
    faults = [fault for one in value.expressions() for fault in infer(one, env)[1]]
    if isinstance(value, Constant):
        return type_of_value(value.data), faults
    if isinstance(value, Fields):
        inner = {key: type_and_faults(item, env)[0] for key, item in value.fields.items()}
        return Type("map", fields=inner), faults
    if isinstance(value, Items):
        return Type(
            "list", item=either([type_and_faults(item, env)[0] for item in value.items])
        ), faults
    return TEXT, faults


@dataclass(frozen=True, slots=True, eq=False)
class StepAt:
    """A step with its place and scope."""

    step: StepBase
    place: Place
    env: Env
    arguments: dict[str, Spot] = field(default_factory=dict)
