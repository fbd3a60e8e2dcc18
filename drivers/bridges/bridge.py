"""A driver whose actions are said in its lab's config: one at a time, recorded, cancelled, made safe.

A bridge's own file says how one action is performed; everything else is here.
"""

import asyncio
import contextlib
import functools
from collections.abc import AsyncIterator
from typing import Any, ClassVar

from pydantic import ValidationError

from ...schemas.contract import Action
from ...schemas.patterns import regular_expression
from ...schemas.quantity import seconds
from ...system.extras import absent
from ...system.tasks import end, first_of, spawn
from ..driver import ActionCanceled, ActionFailed, Driver, GoalContext, Place, misfit
from .answers import BadAnswer, NoNumber
from .channel import Channel
from .config import ActionConfig, BridgeConfig, ErrorConfig, awaited, chosen
from .lines import NoAnswer
from .record import OnceRecord
from .resource import is_visa
from .shared_line import SharedLine

ABORTED_S = 2.0
"""How long an aborted action may take to end by itself; the server gives it 3 s."""
STATUS_S = 1.5
COUNT_S, COUNT_AGAIN_S = 45.0, 0.25
"""How long a probe watches a count, or waits for an instrument that is out of reach; it has 60 s."""
TURN = 3
"""How many times its `timeout` a device waits for a shared line; one that is silent has it for two."""
PASSING = ("Busy", "DeviceBusy", "Lost", "Timeout")
"""Failures of a question that may be answered a moment later."""
Values = dict[str, Any]


class Bridge(Driver):
    """Implements whichever contract its lab says or names."""

    any_contract: ClassVar[bool] = True
    config_model: ClassVar[type[BridgeConfig]]
    _reads: Channel | None = None
    """Where an answer that was given up may still come; none where a library reads."""

    @classmethod
    def lacks(cls, config: dict[str, Any]) -> str | None:
        """PyVISA, too, where the address is one of VISA."""
        over_visa = is_visa(str(config.get("resource", "")))
        return super().lacks(config) or (absent("pyvisa", "visa") if over_visa else None)

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.config: Any = read_config(self.config_model, place.config)
        self._said: dict[str, Any] = self.config.said()
        made = self.config.contract(f"{place.device.lower()}@1")
        self.contract_kept = place.contract or made
        apart = self.contract_kept.actions != made.actions
        for fault in self.config.faults(self.contract_kept, apart=apart):
            where = ".".join(str(part) for part in fault.path)
            raise ValueError(f"config.{where}: {fault.message}")
        self.record = OnceRecord(place.folder)
        shared = getattr(self.config, "shared", False)
        self.line = SharedLine(self.config.resource) if shared else None
        self._turn = asyncio.Lock()
        self.known: Values = {}
        """What the instrument said when it was connected: a key that has to be sent with all that follows."""
        self._latest: Values = {}
        self._looked_at = float("-inf")
        self._look: asyncio.Task[None] | None = None
        for name in self.contract_kept.actions:
            if not hasattr(self, name):
                setattr(self, name, functools.partial(self._do, name))

    def method(self, action: str) -> Any:
        """An action may be called as something of the driver's own is: `open`, `abort`, `status`."""
        return functools.partial(self._do, action)

    async def ready(self, timeout_s: float) -> None:
        """Be connected to the instrument that it was; raises OSError."""

    async def drop(self) -> None:
        """Give up the connection: nothing that is still to come may be taken for something else."""

    def _owe(self, timeout_s: float) -> None:
        """An answer was given up that may still come within this time."""
        if self._reads is not None:
            self._reads.owes(timeout_s)

    def _late_words(self) -> str:
        return self._reads.late_words() if self._reads is not None else ""

    async def perform(self, said: Any, action: Action, values: Values, goal: GoalContext) -> Values:
        """Do one action; raises ActionFailed, NoAnswer, BadAnswer, NoNumber or OSError."""
        raise NotImplementedError

    def params(self, said: Any, action: Action) -> Values:
        """The schemas of what may stand in what is sent, and how each is written."""
        return {**self.config.known(), **self.config.written(action.param_schemas(), said.params)}

    def returns(self, said: Any, action: Action) -> Values:
        """The schemas of what is returned, and how each is written."""
        return self.config.written(action.returns.get("properties", {}), said.returns)

    def named(self, said: Any, code: int | None, text: str) -> tuple[str, ErrorConfig] | None:
        """The error that the lab names for this code, or for an answer with its pattern in it."""
        for name, error in {**self.config.errors, **said.errors}.items():
            fits = error.answer is None or self.pattern(error.answer).search(text)
            if chosen(error, ("code", "answer")) and error.code in (None, code) and fits:
                return name, error
        return None

    def pattern(self, words: str) -> Any:
        """An expression for an answer; raises PatternFault."""
        return regular_expression(words)

    def answers(self, said: Any) -> bool:
        """Whether an action is answered by the instrument: what is only written may be lost."""
        return True

    async def abort(self) -> bool:
        """Tell the instrument to give up what it is doing, past whoever has its turn."""
        name = self.config.abort
        if name is None:
            return False
        with contextlib.suppress(ActionFailed, NoAnswer, BadAnswer):  # what runs says how it ended
            await self._exchange(name, {}, GoalContext("abort"))
        return True

    async def open(self) -> None:
        self.record.open()
        async with self._turn_on_line():
            await self._connect()

    async def _connect(self) -> None:
        """Be ready, or leave nothing open; raises OSError."""
        try:
            await self.ready(self.timeout_s(None))
        except BaseException:  # a cancel as well
            await self.drop()
            raise

    async def greet(self, said: Any) -> None:
        """Do what comes first: what it returns may stand in all that is sent."""
        self.known = {}
        action = Action(returns={"properties": dict(said.returns)})
        self.known = await self.perform(said, action, {}, GoalContext("hello"))

    @contextlib.asynccontextmanager
    async def _turn_on_line(self) -> AsyncIterator[None]:
        """Of a line that others use, too, nobody else has the connection meanwhile; raises OSError."""
        if self.line is None:
            yield
            return
        async with self.line.turn(TURN * self.timeout_s(None)):
            try:
                yield
            except (NoAnswer, BadAnswer):  # what is still to come is not for the next device
                if self._reads is not None:
                    self._reads.owes(self.timeout_s(None))
                    await self._reads.skip_late_answer()
                raise
            finally:
                await self.drop()

    async def _ready_unless_shared(self) -> None:
        """Be ready, unless that has to wait for the line; raises OSError."""
        if self.line is None:
            await self._connect()

    async def _exchange(self, name: str, values: Values, goal: GoalContext) -> Values:
        """Perform it, once connected; of a shared line it is let go of again."""
        said, action = self._said[name], self.contract_kept.actions[name]
        if self.line is None:
            return await self.perform(said, action, values, goal)
        reached = False
        try:
            async with self._turn_on_line():
                await self.ready(self.timeout_s(None))
                reached = True
                return await self.perform(said, action, values, goal)
        except OSError as fault:
            if reached:
                raise
            raise self.failed("Lost", name, f"{fault}; nothing was sent", "no") from fault

    async def close(self) -> None:
        await end(self._look)
        await self.drop()

    def timeout_s(self, said: ActionConfig | None) -> float:
        """How long an action may take to answer."""
        given = said.timeout if said is not None else None
        return seconds(self.config.timeout if given is None else given)

    async def status(self) -> Values:
        """The last values; what is due is read beside, since an instrument may be slow."""
        now = asyncio.get_running_loop().time()
        idle = (self._look is None or self._look.done()) and not self._turn.locked()
        if self.config.status and idle and now - self._looked_at >= seconds(self.config.every):
            self._looked_at = now
            look = self._look = spawn(
                f"look at {self.place.device}", self._read_status(), expected=(OSError,)
            )
            await first_of({look}, STATUS_S)
            if look.done() and (fault := look.exception()) is not None:
                raise fault
        return dict(self._latest)

    async def _read_status(self) -> None:
        for name in self.config.status:
            fields = dict.fromkeys(self._said[name].returns)
            try:
                self._latest |= await self._do(name, GoalContext(f"status:{name}"))
            except ActionFailed as failure:
                self._latest |= fields
                if failure.name not in ("Overload", "NotANumber"):
                    raise OSError(failure.message) from failure

    async def safe(self) -> None:
        """Abort at once; when nothing runs any more, go to the safe state."""
        with contextlib.suppress(OSError):  # what runs says that it is gone
            await self.abort()
        if self._turn.locked() and any(not name.startswith("status:") for name in self._running):
            return  # called again when that has ended
        for name in self.contract_kept.safe_state:
            try:
                await self._do(name, GoalContext(f"safe:{name}"))
            except ActionFailed as failure:
                raise OSError(failure.message) from failure

    @functools.cached_property
    def _running(self) -> set[str]:
        return set()

    async def _do(self, name: str, goal: GoalContext, /, **values: Any) -> Values:
        self._running.add(goal.id)
        try:
            async with self._turn:
                if name not in self._said:
                    return await self._last_once()
                return await self._with_cancel(name, goal, values)
        finally:
            self._running.discard(goal.id)

    async def _with_cancel(self, name: str, goal: GoalContext, values: Values) -> Values:
        action = self.contract_kept.actions[name]
        doing = spawn(
            f"{name} of {self.place.device}", self._recorded(name, goal, values),
            expected=(ActionFailed,),
        )  # fmt: skip
        cancelled = spawn(f"the cancel of {goal.id}", goal.cancelled.wait())
        try:
            await first_of({doing, cancelled})
            if doing.done():
                return doing.result()
            with contextlib.suppress(OSError):  # then `doing` says so
                await self.abort()
            await first_of({doing}, ABORTED_S)
            if doing.done() and not action.cancel:
                return doing.result()
        finally:
            ended = doing.done()
            await end(doing, cancelled)
            if not ended:
                self._owe(self.timeout_s(self._said.get(name)))
                await self.drop()
        if action.cancel:
            raise ActionCanceled
        raise self.failed("Stopped", name, "was stopped; how far it got is not known", "unknown")

    async def _recorded(self, name: str, goal: GoalContext, values: Values) -> Values:
        said, action = self._said[name], self.contract_kept.actions[name]
        try:
            await self._ready_unless_shared()
            once = action.effect == "once"
            if once:
                self.record.begin(goal.id, name, await self._counted(said.count, goal))
        except OSError as fault:
            await self.drop()
            raise self.failed("Lost", name, f"{fault}; nothing was sent", "no") from fault
        try:
            result = await self._attempt(name, goal, values)
            if once and said.count is not None and not self.answers(said):
                await self._until_counted(name, goal)
        except ActionFailed as failure:
            if once:
                self.record.ended(goal.id, failure.happened or action.happened(failure.name))
            raise
        if once:
            self.record.ended(goal.id, "yes", result)
        return result

    async def _until_counted(self, name: str, goal: GoalContext) -> None:
        """What is only written may be lost with the connection; the count says that it arrived."""
        said, clock = self._said[name], asyncio.get_running_loop().time
        before, until = (self.record.begun or {})["count"], clock() + self.timeout_s(said)
        while True:
            try:
                now = await self._attempt(said.count, GoalContext(f"count:{goal.id}"), {})
            except ActionFailed as failure:
                raise doubtful(failure) from failure
            if now != before:
                return
            if clock() >= until:
                words = f"it does not answer, and {said.count} is still {now}"
                raise self.failed("Timeout", name, words, "unknown")
            await asyncio.sleep(COUNT_AGAIN_S)

    async def _counted(self, name: str | None, goal: GoalContext) -> Values | None:
        """The count before a `once` action, of which nothing has been sent yet."""
        try:
            if name is not None:
                return await self._attempt(name, GoalContext(f"count:{goal.id}"), {})
        except ActionFailed as failure:
            raise OSError(failure.message) from failure
        return None

    async def _attempt(self, name: str, goal: GoalContext, values: Values) -> Values:
        """Perform it; what changes nothing is tried again after a missing or wrong answer."""
        said, action = self._said[name], self.contract_kept.actions[name]
        schemas = action.param_schemas()
        values = {n: s["default"] for n, s in schemas.items() if "default" in s} | values
        for again in (action.effect == "pure", False):
            try:
                result = await self._exchange(name, values, goal)
                if said.until is not None:
                    await self._until(said, goal, {**values, **result})
                return result
            except NoNumber as fault:
                raise self.failed(fault.name, name, str(fault), "yes") from fault
            except BadAnswer as fault:
                failure = self.failed("BadAnswer", name, f"{fault}{self._late_words()}")
            except NoAnswer as fault:
                failure = self.failed("Timeout", name, f"{fault}{self._late_words()}", "unknown")
            except OSError as fault:
                failure = self.failed("Lost", name, str(fault), "unknown")
            if failure.name != "Lost":
                self._owe(self.timeout_s(said))
            await self.drop()
            if not again:
                break
            try:
                await self._ready_unless_shared()
            except OSError as fault:
                raise self.failed(
                    "Lost", name, f"{fault} (before: {failure.message})", "unknown"
                ) from fault
        raise failure

    async def _until(self, said: ActionConfig, goal: GoalContext, known: Values) -> None:
        """Ask until the instrument says that it is done; raises NoAnswer when the time is up."""
        wanted, clock = said.until or {}, asyncio.get_running_loop().time
        asked = str(wanted["do"])
        needed = self.contract_kept.actions[asked].param_schemas()
        given = {name: value for name, value in known.items() if name in needed}
        until = clock() + self.timeout_s(said)
        while True:
            await asyncio.sleep(seconds(self.config.poll))  # it may need a moment to begin
            try:
                told = await self._attempt(asked, GoalContext(f"until:{goal.id}"), given)
            except ActionFailed as failure:  # of the question, not of what was asked to be done
                if failure.name not in PASSING or clock() >= until:
                    raise doubtful(failure) from failure
                continue
            if awaited(wanted, known, told):
                return
            goal.feedback(None, ", ".join(f"{name} {value}" for name, value in told.items()))
            if clock() >= until:
                raise NoAnswer(
                    f"it is not done after {self.timeout_s(said):g} s: {asked} is {told}"
                )

    def failed(self, error: str, name: str, words: str, happened: Any = None) -> ActionFailed:
        """A failure that names device and action."""
        return ActionFailed(error, f"{self.place.device}.{name}: {words}", happened)

    async def _last_once(self) -> Values:
        """What is known of the last `once` action; a count is watched as long as it may still change."""
        begun = self.record.begun
        if begun is None:
            return self.record.last()
        said = self._said.get(begun["action"])
        if said is None or said.count is None or begun["count"] is None:
            return {"goal_id": None}
        clock = asyncio.get_running_loop().time
        needed_s = self.timeout_s(said)
        until, back = clock() + min(needed_s, COUNT_S), clock() + COUNT_S
        while True:
            try:
                await self._be_ready(said.count)
                now = await self._attempt(said.count, GoalContext(f"count:{begun['goal']}"), {})
            except ActionFailed as failure:
                limit = back if failure.name == "Lost" else until  # it may be starting anew
                if failure.name not in PASSING or clock() >= limit:
                    raise
            else:
                happened = _by_count(begun["count"], now)
                if happened != "no" or clock() >= until:
                    break
            await asyncio.sleep(COUNT_AGAIN_S)
        if happened == "unknown" or (happened == "no" and needed_s > COUNT_S):
            return {"goal_id": None}
        self.record.ended(begun["goal"], happened)
        return self.record.last()

    async def _be_ready(self, name: str) -> None:
        try:
            await self._ready_unless_shared()
        except OSError as fault:
            raise self.failed("Lost", name, str(fault), "no") from fault


def doubtful(failure: ActionFailed) -> ActionFailed:
    """A refusal that came when something had been sent before: then it may have happened."""
    return ActionFailed(
        failure.name, failure.message, "yes" if failure.happened == "yes" else "unknown"
    )


def _by_count(before: Values, now: Values) -> str:
    """One more (or one less left) is this action; a leap is somebody else's, too, or a new count."""
    if before == now:
        return "no"
    whole = [(before.get(n), v) for n, v in now.items() if isinstance(v, int)]
    if whole and any(isinstance(b, int) and abs(v - b) > 1 for b, v in whole):
        return "unknown"
    return "yes"


def read_config(model: type[BridgeConfig], written: dict[str, Any]) -> BridgeConfig:
    """The config; raises Misfit with its first fault."""
    try:
        return model.model_validate(written)
    except ValidationError as fault:
        raise misfit(fault) from fault
