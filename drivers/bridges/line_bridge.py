"""What `scpi` and `text` share: lines out, and answers that are values, errors, or neither."""

import asyncio
import contextlib
import re
from collections.abc import Iterator
from hashlib import sha256
from typing import Annotated, Any

from pydantic import AfterValidator, field_validator

from ...schemas.contract import Action
from ...schemas.messages import FileContent
from ...schemas.patterns import regular_expression
from ..driver import ActionFailed, GoalContext, Place
from .answers import NUMBER_ERRORS, OWN, BadAnswer, value, values
from .bridge import Bridge, Values, doubtful
from .config import ActionConfig, BridgeConfig, ConfigFault, Pattern, pattern
from .lines import Expired, LineConfig, Lines, NoAnswer
from .number_forms import size_of
from .template import GOAL

BLOCK = re.compile(r"(?:(?P<count>[1-9]\d*)|(?P<length>[<>]?u[1248]):)?(?P<kind>.+)")
ESCAPED = re.compile(r"\\x[0-9a-fA-F]{2}|\\r(?:\\n)?$|\\n$")
"""A sign that was meant to be one, but YAML reads backslashes between double quotes only."""
NAMED = re.compile(r"\{(\w+)")
REFUSED_S = 0.2
"""How long an error may take to come after a command that has no answer."""
MOST_TOLD = 3
"""Lines that were no answer, of those that are named."""


class LineAction(ActionConfig):
    """An action with texts that are sent and an answer that is a text."""

    answer: Pattern | None = None
    lines: Annotated[int | str, AfterValidator(pattern)] | None = None
    block: str | None = None

    @field_validator("lines")
    @classmethod
    def _is_a_number(cls, value: int | str | None) -> int | str | None:
        if isinstance(value, int) and value < 1:
            raise ValueError(f"an answer has at least 1 line, not {value}")
        return value

    @field_validator("block")
    @classmethod
    def _is_a_kind(cls, value: str | None) -> str | None:
        kind = found["kind"] if (found := BLOCK.fullmatch(value or "")) else ""
        with contextlib.suppress(ValueError):
            if value is None or kind == "file" or size_of(kind):
                return value
        raise ValueError(
            f"{value!r} is no kind of block: `file`, or a number type as >f4, <i2, u1, 1024<u2 for so "
            f"many of them without the # of a block, or <u4:>f4 for those that come after their length"
        )


class LineBridgeConfig(LineConfig, BridgeConfig):
    """Address, habits, and actions."""

    own_keys = OWN
    own_errors = NUMBER_ERRORS  # type: ignore[assignment]
    abort_is_action = False

    def faults(self, contract: Any, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        for name, said in self.said().items():
            yield from _unsent(name, said)
            for key, text in said.used():
                if found := ESCAPED.search(text):
                    message = (
                        f"{found[0]} is sent as it stands here; in double quotes it is the one sign: "
                        f'"{found[0]}"'
                    )
                    yield ConfigFault(("actions", name, key), message)
            if said.answer is None:
                continue
            groups = set(regular_expression(said.answer).groupindex)
            if groups and (unnamed := sorted(groups - set(said.returns))) and not apart:
                yield ConfigFault(
                    ("actions", name, "answer"),
                    f"{unnamed[0]} is not among the `returns` of {name}",
                )


def _unsent(name: str, said: ActionConfig) -> Iterator[ConfigFault]:
    """Parameters that a person must give, and that make no difference: `VOLT %f`."""
    sent = [text for _, text in said.used()]
    named = {one for text in (*sent, said.sets, str(said.until)) for one in NAMED.findall(text)}
    if not sent or named - said.params.keys() - {GOAL}:  # one that is misspelt is told by itself
        return
    for one, schema in said.params.items():
        if one not in named and one != said.takes and schema.get("format") != "path":
            message = f"nothing that is sent has {one} in it: write {{{one}}} where it stands"
            yield ConfigFault(("actions", name, "params", one), message, True)


class LineBridge(Bridge):
    """Speaks in lines; `out` counts what has been sent of the action that is under way."""

    out = 0

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.lines = Lines(place, self.config)
        self._reads = self.lines.channel

    async def ready(self, timeout_s: float) -> None:
        if not self.lines.is_open:
            await self.lines.open(timeout_s)
            await self.identify(timeout_s)

    async def identify(self, timeout_s: float) -> None:
        """See that it is the instrument that the lab means; raises OSError."""

    async def drop(self) -> None:
        await self.lines.close()

    async def abort(self) -> bool:
        if self.config.abort is None or not (self.lines.is_open or self.line):
            return False
        if self.lines.is_open:
            await self.lines.at_once(self.config.abort)
            return True
        async with self._turn_on_line():
            await self.ready(self.timeout_s(None))
            await self.lines.at_once(self.config.abort)
        return True

    async def status(self) -> Values:
        latest = await super().status()
        if not (self.lines.is_open or self.line or self._turn.locked()):
            raise OSError(
                f"{self.lines}: {self.lines.channel.fault}; the next action connects again"
            )
        return latest

    def pattern(self, words: str) -> Any:
        return self.lines.pattern(words)

    async def put(self, text: str) -> None:
        """Send a line of an action; after the first, a refusal does not mean that nothing happened."""
        self.out += 1
        await self.lines.send(text)

    async def heard(self, sent: str, said: LineAction, action: Action, goal: GoalContext) -> Values:
        """The values of the answer to what was sent; other lines are passed over until time is up.

        Raises ActionFailed for an answer that is one of the errors.
        """
        clock = asyncio.get_running_loop().time
        until = clock() + self.timeout_s(said)
        wanted = self.pattern(said.answer) if said.answer is not None else None
        returns = self.returns(said, action)
        first, wrong = True, list[str]()
        self.lines.listening_for = None if sent else wanted
        shown = self.lines.shown
        asked = f"it was sent {shown(sent)}" if sent else "it was listened to"
        while True:
            try:
                left = until - clock()
                text = await (
                    self.lines.answer(sent, left) if first else self.lines.next_line(left)
                )
            except NoAnswer as fault:
                if wrong:
                    answers = "; then ".join(dict.fromkeys(wrong))
                    raise BadAnswer(f"{asked} and answered {answers}") from fault
                raise NoAnswer(f"{asked} and {fault}") from fault
            first = False
            self.refuse(sent, text, said)
            try:
                if said.lines is not None:
                    more = await self.lines.lines_after(
                        text,
                        said.lines,
                        until - clock(),
                        json=any("at" in s for s in returns.values()),
                    )
                    text = "\n".join(more)
                return self.read(text, returns, wanted)
            except BadAnswer as fault:
                words = f"{asked} and answered {shown(text[:80])}: {fault}"
                wrong += [f"{shown(text[:80])}: {fault}"][len(wrong) // MOST_TOLD :]
                if self.config.prompt:
                    raise BadAnswer(words) from fault
                goal.feedback(None, words)

    def read(self, text: str, returns: Values, wanted: Any) -> Values:
        """The values of an answer; raises BadAnswer or NoNumber."""
        return values(text, returns, wanted, self.config.decimal)

    async def _exchange(self, name: str, values: Values, goal: GoalContext) -> Values:
        try:
            return await super()._exchange(name, values, goal)
        except Expired as fault:
            await self.drop()
            if self.out > 1:
                raise self.failed("Rejected", name, str(fault), "unknown") from fault
        await self._be_ready(name)
        try:
            return await super()._exchange(name, values, goal)
        except Expired as fault:
            words = f"{fault}, also after a new connection"
            raise self.failed(
                "Rejected", name, words, "no" if self.out <= 1 else "unknown"
            ) from fault

    def refuse(self, sent: str, text: str, said: ActionConfig) -> None:
        """Raise ActionFailed if this answer is an error that the lab names; Expired for a new login."""
        expired, shown = self.config.expired, self.lines.shown
        words = f"it was sent {shown(sent)} and answered {shown(text[:80])}"
        if expired is not None and self.pattern(expired).search(text):
            raise Expired(words)
        known = self.named(said, None, text) or self.named(said, None, self.lines.prompted or text)
        if known is not None:
            name, error = known
            summary = f": {error.summary}" if error.summary else ""
            failure = ActionFailed(name, f"{self.place.device}: {words}{summary}", error.happened)
            raise failure if self.out <= 1 else doubtful(failure)

    async def listen_for_errors(self, sent: str, said: ActionConfig) -> None:
        """A command without an answer may be refused all the same."""
        if self.config.errors or said.errors:
            clock = asyncio.get_running_loop().time
            until = clock() + REFUSED_S
            with contextlib.suppress(NoAnswer):
                while True:  # until the time is up: one that speaks by itself never is silent
                    self.refuse(sent, await self.lines.next_line(until - clock()), said)

    async def answered(
        self, sent: str, said: LineAction, action: Action, given: Values, goal: GoalContext
    ) -> Values:
        """The answer to what was sent, of which a block is the first result, as numbers or a file."""
        if said.block is None:
            return await self.heard(sent, said, action, goal)
        form, timeout_s = BLOCK.fullmatch(said.block), self.timeout_s(said)
        kind = form["kind"] if form else ""
        try:
            if form and (form["count"] or form["length"]):
                count = int(form["count"] or 0) * (size_of(kind) if kind != "file" else 1)
                data = await self.lines.counted_bytes(sent, form["length"], count, timeout_s)
            else:
                data = await self.lines.block(sent, timeout_s)
        except NoAnswer:
            self.refuse(sent, self.lines.heard, said)
            raise
        for name, schema in list(self.returns(said, action).items())[:1]:
            if kind == "file":
                return {name: file_of(goal, name, given, data)}
            return {name: value(data.decode("latin-1"), {**schema, "bytes": kind})}
        return {}


def file_of(goal: GoalContext, name: str, given: Values, data: bytes) -> str:
    """The path at which a result that is a file goes back with the goal."""
    path = str(given.get(name) or f"{name}.bin")
    goal.files[name] = FileContent(path=path, sha256=sha256(data).hexdigest(), data=data)
    return path
