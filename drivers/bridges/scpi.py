"""SCPI instruments: `*IDN?` is checked, and `SYST:ERR?` after each action, as named errors.

IEEE 488.2 and SCPI 1999.0, volume 2, chapter 21. See docs/how-to/instruments-in-yaml.md.
"""

import asyncio
import contextlib
import re
from collections.abc import Iterator
from functools import partial
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Field, model_validator

from ...schemas.contract import Action, Effect, Happened, Name
from ...schemas.patterns import regular_expression
from ..driver import ActionFailed, GoalContext
from .answers import NUMBER_ERRORS, BadAnswer
from .bridge import Values, doubtful
from .config import LISTED, pattern
from .line_bridge import LineAction, LineBridge, LineBridgeConfig
from .lines import NoAnswer
from .template import fill

CLASSES: dict[str, tuple[Happened, str]] = {
    "CommandError": ("no", "The instrument does not know the command (-100 to -199)"),
    "ExecutionError": ("unknown", "The instrument could not carry it out (-200 to -299)"),
    "DeviceError": ("unknown", "The instrument's own error (-300 to -399, or positive)"),
    "QueryError": ("unknown", "A question and its answer have met wrongly (-400 to -499)"),
}
HUNDREDS = {1: "CommandError", 2: "ExecutionError", 4: "QueryError"}
NOT_DONE = {*range(-229, -219), -211, -213, -203}
"""Execution errors by which a command was refused: parameters, triggers, protection."""
ERROR = re.compile(
    r"""\s*([+-]?\d+)(?:\s*[,;:]\s*|\s+(?=["']))(.*)|\s*[+-]?0+\s*|\s*["']?no errors?["']?\s*""",
    re.I,
)
"""A bare number that is not 0 is a late answer to something else..."""
STANDARD = re.compile(r":?SYST(?:EM)?:ERR", re.I)
CODE = re.compile(rf"{ERROR.pattern}|\s*(?P<bare>[+-]?\d+)\s*", re.I)
"""...but the error's code where another question than SCPI's asks for it: `EER?`."""
COMPLETED = re.compile(r"\s*\+?1\s*")
MOST_ERRORS = 30
QUERY = re.compile(r"\s*[*:]?[A-Za-z][\w:]*\?.*", re.S)


class ScpiAction(LineAction):
    """`write`, then `wait` for *OPC?, then `query`; `block` for binary data."""

    write: Annotated[list[str], LISTED] = Field(default_factory=list)
    query: str | None = None
    wait: bool = False

    @model_validator(mode="after")
    def _does_something(self) -> "ScpiAction":
        if not self.write and self.query is None:
            raise ValueError('it needs `query: "MEAS:VOLT:DC?"` or `write: "OUTP ON"`')
        if self.returns and self.query is None:
            raise ValueError("it returns something, so it needs a `query` that asks for it")
        return self

    def guessed_effect(self) -> Effect:
        """A question changes nothing; a command may not happen twice by accident."""
        asks = [part for part in (self.query or "").split(";") if part.strip()]
        only_asks = not self.write and all(QUERY.fullmatch(part) for part in asks)
        return "pure" if only_asks else "once"

    def used(self) -> Iterator[tuple[str, str]]:
        yield from (("write", text) for text in self.write)
        if self.query is not None:
            yield "query", self.query


class ScpiConfig(LineBridgeConfig):
    """The config of `driver: scpi`."""

    own_errors = {**CLASSES, **NUMBER_ERRORS}  # type: ignore[assignment] # noqa: RUF012

    idn: Annotated[str | bool, AfterValidator(pattern)] = True
    error_query: str | bool = "SYST:ERR?"
    actions: dict[Name, ScpiAction] = Field(min_length=1)


class Scpi(LineBridge):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = ScpiConfig
    _identity: str | None = None

    async def identify(self, timeout_s: float) -> None:
        if self.config.idn is False:
            return
        wanted = regular_expression(self.config.idn if isinstance(self.config.idn, str) else "")
        try:
            await self.lines.send("*IDN?")
            said = (await self.lines.answer("*IDN?", timeout_s)).strip()
        except NoAnswer as fault:
            raise OSError(
                f"{self.lines} was sent '*IDN?' and {fault}: check address, terminator and baud rate; "
                f"an instrument that does not know *IDN? needs `idn: false`"
            ) from fault
        with contextlib.suppress(NoAnswer):
            while not wanted.search(said):
                said = (await self.lines.next_line(min(timeout_s, 1.0))).strip()
        if not wanted.search(said):
            raise OSError(
                f"{self.lines} is {said!r}, but the lab expects {self.config.idn!r}: is another "
                f"instrument at this address?"
            )
        if self._identity not in (None, said):
            words = f"{self.lines} is now {said!r}, but was {self._identity!r}: swap them back"
            raise OSError(words)
        self._identity = said
        names = ("manufacturer", "model", "serial_number", "firmware")
        self.versions = dict(zip(names, (part.strip() for part in said.split(",")), strict=False))
        await self._errors()  # those of before are nobody's now

    def answers(self, said: ScpiAction) -> bool:
        return bool(said.wait or said.query or self.config.error_query)

    async def perform(
        self, said: ScpiAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        params = self.params(said, action)
        put = partial(fill, given=values, params=params, goal=goal.id, decimal=self.config.decimal)
        texts = [put(text) for text in said.write]
        query = put(said.query) if said.query is not None else None
        timeout_s, sent = self.timeout_s(said), " ".join([*texts, query or ""]).strip()
        result: Values = {}
        self.out = 0
        try:
            for number, text in enumerate(texts):
                if number:  # a pulse must not go out at the level of before
                    await self._refuse_errors(said, texts[number - 1])
                await self.put(text)
                self.refuse(text, await self.lines.finish(text, timeout_s), said)
                if not self.config.error_query:
                    await self.listen_for_errors(text, said)
            if said.wait:
                await self.lines.send("*OPC?")
                await self._told("*OPC?", COMPLETED, timeout_s, "where 1 is expected")
            if query is not None:
                await self.put(query)
                result = await self.answered(query, said, action, values, goal)
        except (NoAnswer, BadAnswer):
            try:  # an unknown question is not answered, and the error queue says why
                await self._refuse_errors(said, sent)
            except (NoAnswer, OSError, ActionFailed) as why:
                await self.drop()  # its answer may still come
                if isinstance(why, ActionFailed):
                    raise
            raise
        await self._refuse_errors(said, sent)
        return result

    async def _told(self, query: str, wanted: re.Pattern[str], timeout_s: float, why: str) -> Any:
        """The answer of this form; lines that nobody asked for are passed over until time is up."""
        until, told = asyncio.get_running_loop().time() + timeout_s, ""
        try:
            told = await self.lines.answer(query, timeout_s)
            while (found := wanted.fullmatch(told.rpartition("\n")[2])) is None:
                told = await self.lines.next_answer(until)
        except NoAnswer as fault:
            heard = f"answered {told[:80]!r} {why}" if told else str(fault)
            raise NoAnswer(f"it was sent {query!r} and {heard}") from fault
        return found

    async def _errors(self) -> list[tuple[int, str]]:
        """What the instrument's error queue holds; it is empty then."""
        query = self.config.error_query
        if not query:
            return []
        query = "SYST:ERR?" if query is True else query
        found: list[tuple[int, str]] = []
        while len(found) < MOST_ERRORS:
            await self.lines.send(query)
            wanted = ERROR if STANDARD.match(query) else CODE
            error = await self._told(query, wanted, self.timeout_s(None), "which is no error")
            code = int(error[1] or error.groupdict().get("bare") or 0)
            if code == 0:
                break
            found.append((code, (error[2] or "").strip().strip('"')))
        return found

    async def _refuse_errors(self, said: ScpiAction, sent: str) -> None:
        """Raise what is in the queue; of several commands others may have been carried out."""
        found = await self._errors()
        if not found:
            return
        code, _ = found[0]
        words = "; ".join(f"{number} {text}".strip() for number, text in found)
        told = f"{self.place.device} was sent {sent!r} and reports {words}"
        name = HUNDREDS.get(-code // 100, "DeviceError")
        happened: Happened = "no" if code in NOT_DONE or name == "CommandError" else "unknown"
        if known := self.named(said, code, words):
            name, happened = known[0], known[1].happened
        failure = ActionFailed(name, told, happened)
        raise failure if self.out <= 1 and ";" not in sent else doubtful(failure)
