"""What `scpi` and `text` share: lines out, and answers that are values, errors, or neither."""

import asyncio
from collections.abc import Iterator
from typing import Any

from pydantic import field_validator

from ...schemas.contract import Action, Happened
from ...schemas.patterns import regular_expression
from ..driver import ActionFailed, GoalContext, Place
from .answers import BadAnswer, values
from .bridge import Bridge, Values, doubtful
from .config import ActionConfig, BridgeConfig, ConfigFault, pattern
from .lines import LineConfig, Lines, NoAnswer

NUMBER_ERRORS: dict[str, tuple[Happened, str]] = {
    "BadAnswer": ("unknown", "The answer is not what this action returns"),
    "Overload": ("yes", "The instrument answered that the value is beyond its range"),
    "NotANumber": ("yes", "The instrument answered that it has no value"),
}


MOST_TOLD = 3
"""Lines that were no answer, of those that are named."""


class LineAction(ActionConfig):
    """An action with texts that are sent and an answer that is a text."""

    answer: str | None = None

    @field_validator("answer")
    @classmethod
    def _is_a_pattern(cls, value: str | None) -> str | None:
        return pattern(value)


class LineBridgeConfig(LineConfig, BridgeConfig):
    """Address, habits, and actions."""

    own_errors = NUMBER_ERRORS  # type: ignore[assignment]

    def faults(self, contract: Any, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        for name, said in self.said().items():
            if said.answer is None:
                continue
            groups = set(regular_expression(said.answer).groupindex)
            if groups and (unnamed := sorted(groups - set(said.returns))) and not apart:
                yield ConfigFault(
                    ("actions", name, "answer"),
                    f"{unnamed[0]} is not among the `returns` of {name}",
                )


class LineBridge(Bridge):
    """Speaks in lines; `out` counts what has been sent of the action that is under way."""

    out = 0

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.lines = Lines(place, self.config)

    async def ready(self, timeout_s: float) -> None:
        if not self.lines.is_open:
            await self.lines.open(timeout_s)
            await self.identify(timeout_s)

    async def identify(self, timeout_s: float) -> None:
        """See that it is the instrument that the lab means; raises OSError."""

    async def drop(self) -> None:
        await self.lines.close()

    async def abort(self) -> bool:
        if self.config.abort is None or not self.lines.is_open:
            return False
        await self.lines.at_once(self.config.abort)
        return True

    async def status(self) -> Values:
        latest = await super().status()
        if not self.lines.is_open and not self._turn.locked():
            raise OSError(
                f"{self.lines}: {self.lines.channel.fault}; the next action connects again"
            )
        return latest

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
        wanted = regular_expression(said.answer) if said.answer is not None else None
        returns = action.returns.get("properties", {})
        first, wrong = True, list[str]()
        while True:
            try:
                left = until - clock()
                text = await (
                    self.lines.answer(sent, left) if first else self.lines.next_line(left)
                )
            except NoAnswer as fault:
                if wrong:
                    answers = "; then ".join(dict.fromkeys(wrong))
                    raise BadAnswer(f"it was sent {sent!r} and answered {answers}") from fault
                raise NoAnswer(f"it was sent {sent!r} and {fault}") from fault
            first = False
            self.refuse(sent, text, said)
            try:
                return values(text, returns, wanted, self.config.decimal)
            except BadAnswer as fault:
                words = f"it was sent {sent!r} and answered {text[:80]!r}: {fault}"
                wrong += [f"{text[:80]!r}: {fault}"][len(wrong) // MOST_TOLD :]
                if self.config.prompt is not None:
                    raise BadAnswer(words) from fault
                goal.feedback(None, words)

    def refuse(self, sent: str, text: str, said: ActionConfig) -> None:
        """Raise ActionFailed if this answer is an error that the lab names."""
        for name, error in {**self.config.errors, **said.errors}.items():
            if error.answer is not None and regular_expression(error.answer).search(text):
                words = f"it was sent {sent!r} and answered {text[:80]!r}"
                summary = f": {error.summary}" if error.summary else ""
                told = f"{self.place.device}: {words}{summary}"
                failure = ActionFailed(name, told, error.happened)
                raise failure if self.out <= 1 else doubtful(failure)
