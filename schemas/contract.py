"""A contract says what a device can do: its actions, their parameters, errors and effect."""

import re
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints, model_validator

from .model import Model, no_items
from .quantity import Duration, DurationText, same_dimension, seconds

Effect = Literal["pure", "idempotent", "once"]
Happened = Literal["no", "yes", "unknown"]
Danger = Literal["laser", "heat", "pressure", "motion"]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
ContractType = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*@[0-9]+$")]
JsonSchema = dict[str, Any]
PARAMETER = re.compile(r"\{(\w+)\}")

RESERVED_ERRORS: dict[str, Happened] = {
    "Timeout": "unknown",
    "Busy": "no",
    "Rejected": "no",
    "Lost": "unknown",
}
"""Errors that every action may end with, and whether the action happened then."""


class ActionError(Model):
    """One way that an action fails, and whether the action happened all the same."""

    happened: Happened = "unknown"
    summary: str = ""


class Action(Model):
    """One action of a device.

    A `meanwhile` action acts on what the device is currently doing (a feed hold): it is accepted
    while another action is running, and ends that one if it is of the `safe_state`. `interlock` is
    what fields of the status must be for the action to begin; the server reads the status just
    before. `sets` names what an `idempotent` action sets (`energy`, `channel {n}` with the
    parameter `n`): on resume the last one of each is done again. `takes` is the parameter that says
    how long it takes, where one does; `duration` is what it takes otherwise.
    """

    summary: str = ""
    params: JsonSchema = Field(default_factory=dict)
    returns: JsonSchema = Field(default_factory=dict)
    errors: dict[Name, ActionError] = Field(default_factory=dict)
    effect: Effect = "once"
    probe: str | None = None
    duration: DurationText | None = None
    takes: str = ""
    cancel: bool = False
    meanwhile: bool = False
    danger: Danger | None = None
    interlock: dict[str, Any] = Field(default_factory=dict)
    sets: str = ""

    @model_validator(mode="after")
    def _can_be_set_again(self) -> "Action":
        if self.sets and (self.effect != "idempotent" or self.danger == "motion"):
            raise ValueError("what `sets` something is done again on resume: idempotent, no motion")
        schemas = self.param_schemas()
        for name in PARAMETER.findall(self.sets):
            if name not in schemas:
                raise ValueError(f"sets: there is no parameter {name}")
            if name not in self.required() and "default" not in schemas[name]:
                raise ValueError(f"sets: {name} may be left out, and then names nothing")
        return self

    @model_validator(mode="after")
    def _takes_a_time(self) -> "Action":
        unit = self.param_schemas().get(self.takes, {}).get("unit")
        if self.takes and (unit is None or not same_dimension(unit, "s")):
            raise ValueError(f"takes: there is no parameter {self.takes} with a unit of time")
        return self

    def typical_s(self, params: dict[str, Any]) -> float | None:
        """How many seconds it takes with these parameters, in the contract's units; None if nobody says."""
        schema = self.param_schemas().get(self.takes, {})
        given = params.get(self.takes, schema.get("default"))
        if given is not None:
            return seconds(f"{given} {schema['unit']}")
        return None if self.duration is None else seconds(self.duration)

    def hung_after_s(self, params: dict[str, Any]) -> float | None:
        """How long it may take where nobody has given it a timeout: well past what it usually does."""
        typical_s = self.typical_s(params)
        return None if typical_s is None else 10 * typical_s + 30

    def setting(self, params: dict[str, Any]) -> str:
        """What it sets with these parameters; empty for nothing that has to be set again."""
        if not self.sets:
            return ""
        defaults = {n: s["default"] for n, s in self.param_schemas().items() if "default" in s}
        given = {**defaults, **params}
        return PARAMETER.sub(lambda found: str(given[found[1]]), self.sets)

    def param_schemas(self) -> dict[str, JsonSchema]:
        """Parameter name -> its JSON Schema."""
        known = self.params.get("properties", {})
        return dict(known) if isinstance(known, dict) else {}  # what else it is, its check tells

    def required(self) -> list[str]:
        """Names of the parameters that must be given."""
        return list(self.params.get("required", []))

    def path_params(self) -> tuple[list[str], list[str]]:
        """Parameters of `format: path`, as (read by the device, written by the device).

        A path that the action also returns is written; every other one is read.
        """
        returned = self.returned_paths()
        paths = [n for n, s in self.param_schemas().items() if s.get("format") == "path"]
        return [n for n in paths if n not in returned], [n for n in paths if n in returned]

    def returned_paths(self) -> list[str]:
        """Names of the results of `format: path`: files that travel back with the result."""
        properties = self.returns.get("properties", {})
        return [n for n, s in properties.items() if s.get("format") == "path"]

    def happened(self, error: str) -> Happened:
        """Whether the action happened if it ended with this error."""
        if error in self.errors:
            return self.errors[error].happened
        return RESERVED_ERRORS.get(error, "unknown")


class Contract(Model):
    """What one kind of device promises, under a name with its major version.

    `also` are earlier contracts that it keeps, too: a device of this one can play their roles.
    `cancel_grace` is how long its driver may take to end an action that was cancelled, `lapse_grace` how long
    an action may go on after its lease is over, where `on_lease_lapse` lets it finish, `look_timeout` how
    long a picture between goals may take at least.
    """

    type: ContractType
    also: list[ContractType] = Field(default_factory=no_items)
    summary: str = ""
    concurrent: bool = False
    safe_state: list[str] = Field(default_factory=no_items)
    on_lease_lapse: Literal["finish", "cancel", "safe"] = "finish"
    lapse_grace: Duration = "10 min"
    cancel_grace: Duration = "3 s"
    look_timeout: Duration = "10 s"
    status: JsonSchema = Field(default_factory=dict)
    actions: dict[Name, Action] = Field(min_length=1)

    def look(self) -> tuple[str, str] | None:
        """How a picture is taken with it at any time: the action, and its parameter for the file.

        The action is `pure` and without danger or interlock, needs nothing but the file's name, and the
        file is a picture by its `contentMediaType`. None for a device that is no camera.
        """
        for name, action in self.actions.items():
            _, written = action.path_params()
            kinds = {n: action.param_schemas()[n].get("contentMediaType", "") for n in written}
            harmless = action.effect == "pure" and action.danger is None and not action.interlock
            match action.required():
                case [file] if harmless and str(kinds.get(file, "")).startswith("image/"):
                    return name, file
        return None

    def looks_from_above(self) -> bool:
        """Whether such a look can be asked for as seen from straight above: it takes `above`."""
        look = self.look()
        return look is not None and "above" in self.actions[look[0]].param_schemas()

    def look_s(self) -> float:
        """How long such a picture may take: three times what the contract says it usually takes, at least."""
        look = self.look()
        usual_s = self.actions[look[0]].typical_s({}) if look is not None else None
        return max(seconds(self.look_timeout), 3 * (usual_s or 0.0))

    def keeps(self, contract: str) -> bool:
        """Whether a device of this contract can play a role that needs that one."""
        return contract == self.type or contract in self.also

    @property
    def lapse_grace_s(self) -> float:
        """The same in seconds."""
        return seconds(self.lapse_grace)

    @property
    def cancel_grace_s(self) -> float:
        """The same in seconds."""
        return seconds(self.cancel_grace)
