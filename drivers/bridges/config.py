"""Actions as a device's `config:` says them, and the contract that they make.

Every bridge has the same keys for what an action is; how it is done (`query`, `send`, `get`, `read`)
are the bridge's own. A contract may also stand apart: then `params` and `returns` may be left out.
"""

import contextlib
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from ...schemas.contract import (
    Action,
    ActionError,
    Contract,
    Danger,
    Effect,
    Happened,
    JsonSchema,
    Name,
)
from ...schemas.model import Model
from ...schemas.patterns import PatternFault, regular_expression
from ...schemas.quantity import Duration, seconds

LAST_ONCE = "last_once"
"""The probe of every `once` action without its own: the driver's record of what it sent."""
WITHIN = "within"
UNTIL = ("do", WITHIN)
"""What `until` says beside the results that it waits for."""
WHOLE = re.compile(r"\{(\w+)\}")
"""A placeholder that stands alone: the value itself, not its text."""


def pattern(value: Any) -> Any:
    """A regular expression, or what is no text; raises ValueError with the reason if it is none."""
    try:
        if isinstance(value, str):
            regular_expression(value)
    except PatternFault as fault:
        raise ValueError(f"{value!r} is not a regular expression: {fault}") from fault
    return value


def chosen(model: Model, names: Collection[str]) -> list[str]:
    """Those of its keys that are said."""
    return [name for name in names if getattr(model, name) is not None]


Pattern = Annotated[str, AfterValidator(pattern)]
LISTED = BeforeValidator(
    lambda value: value if isinstance(value, list) else [] if value is None else [value]
)
"""One may stand for a list of one."""


@dataclass(frozen=True, slots=True)
class ConfigFault:
    """What is wrong in a config, at the path of its key or value."""

    path: tuple[str | int, ...]
    message: str
    key: bool = False


class ErrorConfig(ActionError):
    """An error: its code (SCPI, HTTP, Modbus) or a pattern of the answer by which it is known."""

    code: int | None = None
    answer: Pattern | None = None


class ActionConfig(Model):
    """What is read or done: what every action and status field has in common."""

    summary: str = ""
    params: dict[Name, JsonSchema] = Field(default_factory=dict)
    returns: dict[Name, JsonSchema] = Field(default_factory=dict)
    errors: dict[Name, ErrorConfig] = Field(default_factory=dict)
    effect: Effect | None = None
    probe: str | None = None
    count: str | None = None
    duration: Duration | None = None
    takes: str = ""
    timeout: Duration | None = None
    until: dict[str, Any] | None = None
    cancel: bool = False
    danger: Danger | None = None
    sets: str = ""

    def guessed_effect(self) -> Effect:
        """`once` unless the bridge knows better: it may not happen twice by accident."""
        return "once"

    def used(self) -> Iterator[tuple[str, str]]:
        """(key, text) of everything with {placeholders}."""
        return iter(())


class BridgeConfig(Model):
    """What every bridge's config has: actions, status, safe state."""

    own_keys: ClassVar[tuple[str, ...]] = ()
    """Keys of a value that say where it is found or how it is written; no part of the contract."""
    elsewhere: ClassVar[str] = ": a library's value is what it is; compute in the protocol"
    """Where those keys stand that this config's values do not have."""
    own_errors: ClassVar[dict[str, tuple[Happened, str]]] = {}
    abort_is_action: ClassVar[bool] = True
    """Its name; otherwise the text that is sent."""

    summary: str = ""
    timeout: Duration = 5
    errors: dict[Name, ErrorConfig] = Field(default_factory=dict)
    safe_state: list[str] = Field(default_factory=list)
    on_lease_lapse: Literal["finish", "cancel", "safe"] = "finish"
    every: Duration = 5
    poll: Duration = 0.5
    status: list[str] = Field(default_factory=list)
    abort: str | None = None

    def said(self) -> dict[str, Any]:
        """Action name -> its `ActionConfig`."""
        return dict(getattr(self, "actions", {}))

    def known(self) -> dict[str, JsonSchema]:
        """What the instrument says when it is connected: its values may stand in all that is sent."""
        return {}

    def contract(self, type_: str) -> Contract:
        """The contract that this config says."""
        actions = {name: self._action(said) for name, said in self.said().items()}
        kept = {n for n, a in actions.items() if a.probe == LAST_ONCE}
        if kept and LAST_ONCE not in actions:
            actions[LAST_ONCE] = _last_once([actions[name] for name in sorted(kept)])
        fields = [self.said()[n].returns for n in self.status if n in self.said()]
        status = {n: self._nullable(s) for returns in fields for n, s in returns.items()}
        return Contract(
            type=type_, summary=self.summary, safe_state=self.safe_state,
            on_lease_lapse=self.on_lease_lapse, actions=actions,
            status={"type": "object", "properties": status} if status else {},
        )  # fmt: skip

    def _action(self, said: ActionConfig) -> Action:
        effect = said.effect or said.guessed_effect()
        errors = {n: ActionError(happened=h, summary=s) for n, (h, s) in self.own_errors.items()}
        for name, error in {**self.errors, **said.errors}.items():
            errors[name] = ActionError(happened=error.happened, summary=error.summary)
        params = {name: self._plain(schema) for name, schema in said.params.items()}
        needed = [name for name, schema in params.items() if "default" not in schema]
        returns = {name: self._plain(schema) for name, schema in said.returns.items()}
        return Action(
            summary=said.summary, effect=effect, errors=errors, duration=self._duration(said),
            probe=said.probe or (LAST_ONCE if effect == "once" else None), cancel=said.cancel,
            danger=said.danger, sets=said.sets, takes=said.takes,
            params=_object(params, needed, closed=True) if params else {},
            returns=_object(returns, list(returns)) if returns else {},
        )  # fmt: skip

    def _duration(self, said: ActionConfig) -> str:
        """Unless it is said: a second, or half of a longer timeout."""
        limit_s = seconds(self.timeout if said.timeout is None else said.timeout)
        usual_s = limit_s / 2 if limit_s > 10 else 1.0
        asked = said.duration or usual_s
        return asked if isinstance(asked, str) else f"{asked:g} s"

    def _plain(self, schema: JsonSchema) -> JsonSchema:
        own = {key: schema[key] for key in self.own_keys if key in schema}
        plain = {key: value for key, value in schema.items() if key not in own}
        if isinstance(own.get("words"), dict) and "type" not in plain:
            from .answers import words_of

            with contextlib.suppress(ValueError):  # a word that is no number is told as a fault
                plain = {"enum": list(words_of(schema)), **plain}
        elif "bit" in own:
            plain = {"type": "boolean", **plain}
        elif "bits" in own and "unit" not in plain:
            plain = {"type": "integer", **plain}
        return typed(plain)

    def written(
        self, schemas: Mapping[str, JsonSchema], said: Mapping[str, JsonSchema]
    ) -> dict[str, JsonSchema]:
        """A contract's schemas with the own keys that the lab says beside them."""
        return {
            name: {**schema, **{k: v for k, v in said.get(name, {}).items() if k in self.own_keys}}
            for name, schema in schemas.items()
        }

    def _nullable(self, schema: JsonSchema) -> JsonSchema:
        """In a status, a value that is not known is null."""
        plain = self._plain(schema)
        kinds = plain["type"] if isinstance(plain["type"], list) else [plain["type"]]
        return {**plain, "type": [*kinds, *([] if "null" in kinds else ["null"])]}

    def faults(self, contract: Contract, *, apart: bool) -> Iterator[ConfigFault]:
        """What the models cannot see: names that must agree, units, placeholders.

        `apart` if the contract stands in a file of its own.
        """
        said = self.said()
        ours = {a.probe for a in contract.actions.values()} - set(said)
        for name in contract.actions:
            if name not in said and not (apart and name in ours) and name != LAST_ONCE:
                yield ConfigFault(("actions",), f"{name} of {contract.type} is not said here", True)
        for name, one in said.items():
            if name in contract.actions:
                action = contract.actions[name]
                for fault in self._action_faults(name, one, action, apart=apart):
                    yield ConfigFault(("actions", name, *fault.path), fault.message, fault.key)
            else:
                message = (
                    f"{contract.type} has no action {name}; it has {_listed(contract.actions)}"
                )
                yield ConfigFault(("actions", name), message, True)
        for key, names in (("safe_state", self.safe_state), ("status", self.status)):
            for index, name in enumerate(names):
                yield from self._named((key, index), name)
        if self.abort is not None and self.abort_is_action:
            yield from self._named(("abort",), self.abort)

    def _action_faults(
        self, name: str, said: ActionConfig, action: Action, *, apart: bool
    ) -> Iterator[ConfigFault]:
        from .schema_faults import schema_faults

        for part in ("params", "returns"):
            for one, schema in getattr(said, part).items():
                for path, message, key in schema_faults(
                    f"{name} {one}", schema, self.own_keys, self.elsewhere
                ):
                    yield ConfigFault((part, one, *path), message, key)
        if apart and (said.params or said.returns):
            made, given = self._action(said), (action.param_schemas(), action.returns)
            if (made.param_schemas(), made.returns.get("properties", {})) != (
                given[0], given[1].get("properties", {}),
            ):  # fmt: skip
                part = "params" if made.param_schemas() != given[0] else "returns"
                message = (
                    f"{part} of {name} differ from those of its contract's file; say them once"
                )
                yield ConfigFault((part,), message, True)
        for key in ("probe", "count"):
            if getattr(said, key) not in (None, LAST_ONCE):
                yield from self._named((key,), getattr(said, key))
        if said.until is not None:
            known = {*action.param_schemas(), *action.returns.get("properties", {})}
            yield from self._until_faults(said.until, known)
        if said.cancel and self.abort is None:
            message = "to cancel it, the instrument must be told to: give the config an `abort`"
            yield ConfigFault(("cancel",), message)
        from .template import template_faults

        for key, text in said.used():
            params = {**self.known(), **self.written(action.param_schemas(), said.params)}
            for message in template_faults(text, params):
                yield ConfigFault((key,), message)

    def _until_faults(self, until: dict[str, Any], known: set[str]) -> Iterator[ConfigFault]:
        """`known` are the values that the action has, which the question may need."""
        asked, fields = until.get("do"), [name for name in until if name not in UNTIL]
        within = until.get(WITHIN, 1)
        if isinstance(within, bool) or not isinstance(within, int | float) or within <= 0:
            message = f"{within!r} is not how far it may be off: a number above 0, such as 0.1"
            yield ConfigFault(("until", WITHIN), message)
        if not isinstance(asked, str) or not fields:
            message = (
                "say which action is asked, and what it has to return: {do: state, state: idle}"
            )
            yield ConfigFault(("until",), message)
            return
        yield from self._named(("until", "do"), asked, known=known)
        returned = self.said()[asked].returns if asked in self.said() else {}
        for name in fields:
            if returned and name not in returned:
                whole = f"; `{name}` is said once, for the whole config" if name == "poll" else ""
                yield ConfigFault(
                    ("until", name),
                    f"{asked} returns no {name}; it returns {_listed(returned)}{whole}",
                    True,
                )
            asked_for = WHOLE.fullmatch(wanted) if isinstance(wanted := until[name], str) else None
            if asked_for is not None and asked_for[1] not in known:
                message = f"{wanted}: the action has no parameter and no result {asked_for[1]!r}; "
                yield ConfigFault(("until", name), message + f"it has {_listed(sorted(known))}")

    def _named(
        self, path: tuple[str | int, ...], name: str, *, known: Collection[str] = ()
    ) -> Iterator[ConfigFault]:
        said = self.said()
        if name not in said:
            yield ConfigFault(path, f"there is no action {name}; there is {_listed(said)}")
            return
        needs = [n for n, s in said[name].params.items() if "default" not in s and n not in known]
        if needs:
            without = f"without {needs[0]}" if known else "without parameters"
            message = f"{name} is called {without}, but it needs {_listed(needs)}"
            yield ConfigFault(path, message)


def awaited(until: Mapping[str, Any], known: Mapping[str, Any], told: Mapping[str, Any]) -> bool:
    """Whether an answer is what `until` waits for: the same, or within so much of a number."""
    within = until.get(WITHIN, 0)
    for name, said in until.items():
        wanted, found = of_action(said, known), told.get(name)
        numbers = all(type(one) in (int, float) for one in (wanted, found))
        near = numbers and abs(found - wanted) <= within * (1 + 1e-9)  # 20.1 - 20 is more than 0.1
        if name not in UNTIL and found != wanted and not near:
            return False
    return True


def of_action(wanted: Any, known: Mapping[str, Any]) -> Any:
    """What `until` waits for: as it is said, or "{n}" of what the action was given or has returned."""
    named = WHOLE.fullmatch(wanted) if isinstance(wanted, str) else None
    return wanted if named is None else known.get(named[1])


def typed(schema: JsonSchema) -> JsonSchema:
    """With its `type`: a number where there is a unit or a range, that of its choices, or text."""
    if "type" in schema:
        return schema
    if {"unit", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"} & set(schema):
        return {"type": "number", **schema}
    if "format" in schema:
        return {"type": "string", **schema}
    samples = [*schema.get("enum", []), *([schema["default"]] if "default" in schema else [])]
    kinds = {bool: "boolean", int: "integer", float: "number", str: "string"}
    return {"type": kinds.get(type(samples[0]), "string") if samples else "number", **schema}


def _object(properties: dict[str, Any], needed: list[str], *, closed: bool = False) -> JsonSchema:
    shape: JsonSchema = {"type": "object", "properties": properties}
    if closed:
        shape["additionalProperties"] = False
    return {**shape, "required": needed} if needed else shape


def _last_once(actions: list[Action]) -> Action:
    fields: dict[str, Any] = {"goal_id": {"type": ["string", "null"]}}
    for action in actions:
        for name, schema in action.returns.get("properties", {}).items():
            fields[name] = schema if fields.get(name, schema) == schema else {}
    return Action(
        summary="What the driver's record says about the last `once` action",
        effect="pure", returns=_object(fields, ["goal_id"]),
    )  # fmt: skip


def _listed(names: Any) -> str:
    return ", ".join(names) or "none"
