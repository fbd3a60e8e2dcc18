"""Goals on their way: queued for their devices, journaled, sent, cancelled, and drained.

The tree only asks and reads. What takes time is here: one goal at a time per device, cancels that
are awaited, timeouts of actions, and the order journal first, wire second.
"""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from ...drivers.client.client import LeaseHeld, Outcome, ServerUnreachable
from ...schemas import journal as j
from ...schemas.contract import Contract, Happened
from ...schemas.messages import ENDED, Goal, GoalError, GoalReport
from ...system.tasks import end, spawn
from ..journal.history import LAPSED, LOOKS, RESTARTED, STOPPED
from ..journal.past import PastGoal
from ..run.files import read_content, write_content
from ..run.names import FileFault
from ..run.reservations import Reservations
from ..run.run import Run
from .device_handle import DeviceHandle
from .probe import checked_with_server
from .request import CANCELED_BEFORE_SENDING, Request

LOG = logging.getLogger("labrun")
CANCEL_GRACE_S = 10.0
"""How long a device may take to end a goal after its timeout before the next attempt or fallback,
unless its contract gives its driver longer."""
OWN_S = 2.0
"""What the server takes beside its driver."""


class Dispatcher:
    """Carries requests to devices; `wake` is set when an outcome has arrived.

    `out_of_touch_s`: how long `once` actions wait for another device whose server is out of reach or
    ending. It may lose the state that earlier steps gave it, and only its server can say so.
    """

    def __init__(
        self, run: Run, clients: Mapping[str, DeviceHandle], out_of_touch_s: float = 60.0
    ) -> None:
        self.run = run
        self.clients = clients
        self.out_of_touch_s = out_of_touch_s
        self._limit = f"{out_of_touch_s:g} s (`start_timeout`)"
        self.wake = asyncio.Event()
        self.paused = False
        self.disk_full: str = ""
        self.stopped: dict[str, str] = {}
        """Devices that another client has stopped -> who, and when: the run must pause."""
        self.heeds_stops = False
        """Whether a stop pauses what runs now; where not, what a stop cuts has failed."""
        self.reservations = Reservations()
        self._queue: deque[Request] = deque()
        self._under_way: dict[str, Request] = {}
        self._holders: dict[str, Request] = {}
        self._stuck: dict[str, Request] = {}
        self._arrived: deque[tuple[Request, Outcome]] = deque()
        self._tasks: set[asyncio.Task[None]] = set()
        self._lasting = {r.device for r in run.roles.values() if _has_state(r.contract)}
        self._known = self._standing()
        for client in clients.values():
            client.on_stopped = self._was_stopped
            client.on_touch = self.wake.set
            client.on_told = self._told
        self._out_of_touch: dict[str, float] = {}
        """Device -> until when it is waited for; 0 once that is over."""

    # --- what the tree asks for

    def request(self, request: Request, *, first: bool = False) -> Request:
        """Queue an action; it is sent when its device is free and the tick is over.

        `first`: before anything else that waits for the device, as a probe must be.
        """
        holder = self._stuck.get(request.device)
        if holder is not None and holder.goal_id == request.goal_id:
            request.outcome = holder.outcome  # asked about before, and given up then
        elif holder is not None:
            message = f"{request.device} is still busy with {holder.label} and does not end it"
            request.outcome = _aborted("Busy", message, "no")
        elif first:
            self._queue.appendleft(request)
        else:
            request.asked = self.reservations.next()
            self._queue.append(request)
        return request

    def replayed(self, request: Request, past: PastGoal) -> None:
        """An action counts as done from the journal; nothing is sent."""

    def another_watch(self, path: str, was: str, now: str) -> None:
        """In a changed protocol, a watch that was right is not that which it was."""

    def withdraw(self, request: Request) -> None:
        """This action is no longer needed: drop it from the queue, or cancel it."""
        if request.outcome is not None or request.cut:
            return
        request.withdrawn = True
        if request in self._queue:
            self._queue.remove(request)
            request.outcome = CANCELED_BEFORE_SENDING
        elif request.sent_at is None:
            self._take_back(request)
        else:
            self._cancel(request)

    def states_lost(self) -> dict[str, str]:
        """Devices with a state that may be lost since `look_anew`, each with the reason."""
        now = self._standing()
        if now == self._known:
            return {}
        return {
            device: RESTARTED if now[device][0] != boot else LAPSED
            for device, (boot, epoch) in self._known.items()
            if now[device] != (boot, epoch)
        }

    def look_anew(self) -> None:
        """From now on compare with the devices' present state; the journal records the leases."""
        self._known = self._standing()
        self.stopped.clear()
        for device, client in self.clients.items():
            self.run.record(
                j.Leased(
                    device=device, epoch=client.epoch(device), boot=client.boot, mark=client.mark,
                    continues=client.continues,
                )
            )  # fmt: skip
            client.continues = True

    def _standing(self) -> dict[str, tuple[str, int]]:
        """Boot and epoch of every device that has a state to lose."""
        return {d: (c.boot, c.epoch(d)) for d, c in self.clients.items() if d in self._lasting}

    def _told(self) -> None:
        if self.run.watches_changes:
            self.wake.set()

    # --- stops by others

    def _was_stopped(self, device: str, words: str) -> None:
        if self.heeds_stops and device in self.clients and device not in self.stopped:
            self.stopped[device] = words
            self.wake.set()

    def _was_cut(self, request: Request, outcome: Outcome) -> bool:
        """True if a stop has ended or refused a goal, which is not a failure of its step."""
        ours = request.withdrawn or request.expired
        if not self.heeds_stops or ours or outcome.state == "SUCCEEDED":
            return False
        if outcome.error is None and outcome.state == "CANCELED":
            self._was_stopped(request.device, f"{request.label} was cancelled by another client")
        elif outcome.error is not None and outcome.error.name == STOPPED:
            self._was_stopped(request.device, outcome.error.message)
        else:
            return False
        return True

    async def take_stopped_again(self) -> str:
        """Take the leases of stopped devices, on a person's word; why it cannot be, or nothing."""
        for device in self.stopped:
            try:
                await self.clients[device].take_lease(device, self.run.id)
            except (LeaseHeld, ServerUnreachable) as fault:
                return str(fault)
        return ""

    # --- one round of the runner

    @property
    def draining(self) -> bool:
        """True while a cancelled goal has not ended: nothing new is sent until then."""
        return any(r.withdrawn and r.outcome is None for r in self._under_way.values())

    @property
    def busy(self) -> bool:
        """True while goals are under way or outcomes are not yet applied."""
        return bool(self._under_way or self._arrived)

    def has_arrived(self) -> bool:
        """True when outcomes wait to be applied."""
        return bool(self._arrived)

    def longest_s(self) -> float:
        """Twice what the slowest action under way takes, by its contract."""
        known = [2 * (r.action.typical_s(r.params) or 0.0) for r in self._under_way.values()]
        return max(known, default=0.0)

    def waits_for(self) -> list[str]:
        """What has not ended, or not begun: what, on whom, since when."""
        now = self.run.clock.now()
        told = [
            f"{r.label} on {r.device}, sent at {_at(now - (r.sent_at or now))}"
            for r in self._under_way.values()
        ]
        away = {device: until for device, until in self._out_of_touch.items() if until}
        for request in () if self.paused else self._queue:
            holder = self._holders.get(request.device)
            behind = f", which does {holder.label}" if holder is not None else ""
            if others := self._kept_by(request, away):
                until = ", ".join(f"{d} until {_at(now - away[d])} at most" for d in others)
                behind = f", which waits for {until}"
            told.append(f"{request.device}{behind}, to begin {request.label}")
        return told

    def apply(self) -> None:
        """Take in every outcome that has arrived: files first, then the journal, then the tree."""
        while self._arrived:
            request, outcome = self._arrived.popleft()
            self._under_way.pop(request.goal_id, None)
            if self._holders.get(request.device) is request:
                del self._holders[request.device]
            if self._stuck.get(request.device) is request:
                del self._stuck[request.device]
            outcome, written = self._keep_files(outcome)
            request.cut = self._was_cut(request, outcome)
            if request.outcome is None and not request.cut:
                request.outcome = outcome
            if outcome.state != "LOST":
                self.run.record(
                    j.GoalEnded(
                        id=request.goal_id, state=outcome.state, result=outcome.result,
                        error=outcome.error, files=written,
                    )
                )  # fmt: skip
            self.run.tell("goal", request.path, outcome.state.lower(), request.label)
            if outcome.state == "SUCCEEDED" and outcome.error is not None:
                self.run.log(f"{request.label} was done, but {outcome.error.message}", request.path)

    def _keep_files(self, outcome: Outcome) -> tuple[Outcome, dict[str, str]]:
        written: dict[str, str] = {}
        try:
            for name, content in outcome.files.items():
                if outcome.result is not None and outcome.result.get(name) == content.path:
                    written[content.path] = write_content(
                        self.run.folder, content, sync=self.run.journal.sync
                    )
        except FileFault as fault:
            return _aborted("Fault", str(fault), "yes"), {}
        except OSError as fault:
            self.disk_full = f"cannot write {self.run.folder}: {fault.strerror}"
            return _aborted("DiskFull", self.disk_full, "yes"), {}
        return outcome, written

    def check_time(self) -> None:
        """Cancel what took longer than its timeout; give up on what does not end after that."""
        now = self.run.clock.now()
        for request in list(self._under_way.values()):
            if request.canceled_at is not None:
                self._check_grace(request, now)
            elif request.timeout_s is not None and request.sent_at is not None:
                until = request.sent_at + request.timeout_s
                if now >= until:
                    request.expired = True
                    if request.adopt is None:  # of an adopted one nobody knows its real age
                        self.run.record(j.Expired(id=request.goal_id))
                    self._cancel(request)
                    self._check_grace(request, now)
                else:
                    self.run.requests.wake_at(until)

    def _check_grace(self, request: Request, now: float) -> None:
        assert request.canceled_at is not None
        grace_s = max(CANCEL_GRACE_S, _ends_within_s(request))
        until = request.canceled_at + grace_s
        if now < until:
            self.run.requests.wake_at(until)
        elif request.outcome is None and (request.expired or request.withdrawn):
            self._stuck[request.device] = request
            message = (
                f"{request.label} took longer than {request.timeout_s:g} s and did not end "
                if request.expired and request.timeout_s is not None
                else f"{request.label} was cancelled and did not end "
            )
            request.outcome = _aborted("Timeout", f"{message}within {grace_s:g} s", "unknown")
            self.run.requests.again()

    def prepare(self) -> list[Request]:
        """Choose what can be sent now and put the intents into the journal."""
        if self.draining or self.disk_full or (self.paused and not self._urgent()):
            return []
        ready: list[Request] = []
        waiting: deque[Request] = deque()
        if self.reservations.waiting or self.reservations.held:
            self._grant()
        taken = {r.device for r in self._under_way.values() if not r.role.contract.concurrent}
        away = self._away()
        for request in self._queue:
            held = self.paused and not (request.urgent and request.device not in self.stopped)
            if held or self._kept_by(request, away):
                waiting.append(request)
                continue
            if (request.exclusive and request.device in taken) or not self._has_turn(request):
                waiting.append(request)
                continue
            if not request.role.contract.concurrent:
                taken.add(request.device)
            ready.append(request)
        self._queue = waiting
        for request in ready:
            self._note(request)
        return ready

    def _grant(self) -> None:
        """Grant reservations, after single actions that asked before and wait for their device."""
        singles = [
            (r.asked, r.device, r.reservation)
            for r in self._queue
            if r.exclusive and self._has_turn(r)
        ]
        if self.reservations.grant(singles):
            self.run.requests.again()

    def _has_turn(self, request: Request) -> bool:
        """Whether no other group has its device for itself; to read it does not matter."""
        if not self.reservations.held or request.path.endswith(LOOKS):
            return True
        return self.reservations.may_use(request.device, request.reservation)

    def _urgent(self) -> bool:
        return any(request.urgent for request in self._queue)

    def status(self, device: str) -> tuple[dict[str, Any], float]:
        """What a device told of itself when its driver last could, and when by the event loop."""
        return self.clients[device].newest_status(device)

    def _kept_by(self, request: Request, away: Mapping[str, float]) -> list[str]:
        """Other devices that a `once` action waits for."""
        return sorted(away.keys() - {request.device}) if request.action.effect == "once" else []

    def _away(self) -> dict[str, float]:
        """Devices with a state that are out of touch, and until when they are waited for."""
        now, used = self.run.clock.now(), self.run.history.boots
        for device, client in self.clients.items():
            until = self._out_of_touch.get(device)
            if client.in_touch or device not in self._lasting or device not in used:
                self._out_of_touch.pop(device, None)
            elif until is None:
                self._out_of_touch[device] = now + self.out_of_touch_s
                self.run.log(
                    f"{device} is out of reach: until it is back, and for {self._limit} at most, "
                    "no action that must not be repeated begins on other devices"
                )
            elif until and until <= now:
                self._out_of_touch[device] = 0.0
                self.run.log(f"{device} is not back after {self._limit}; going on without it")
        away = {device: until for device, until in self._out_of_touch.items() if until}
        for until in away.values():
            self.run.requests.wake_at(until)
        return away

    def _note(self, request: Request) -> None:
        client = self.clients[request.device]
        request.epoch = request.adopt.sent.epoch if request.adopt else client.epoch(request.device)
        if request.adopt is None:
            self.run.record(
                j.GoalSent(
                    id=request.goal_id, device=request.device, action=request.action_name,
                    params=request.params, effect=request.action.effect, boot=client.boot,
                    ledger=client.ledger, epoch=request.epoch,
                    means=request.means(), timeout_s=request.timeout_s,
                    sets=request.action.setting(request.params),
                )
            )  # fmt: skip
        if request.action.effect != "pure":
            strand = request.strand or request.within
            self.run.strands.note(request.device, self.run.history.last_n, strand)
        if request.exclusive:
            self._holders[request.device] = request
        self._under_way[request.goal_id] = request

    def send(self, requests: list[Request]) -> None:
        """Send the goals whose intents are on disk."""
        for request in requests:
            request.sent_at = self.run.clock.now()
            if request.timeout_s is not None:
                self.run.requests.wake_at(request.sent_at + request.timeout_s)
            self._spawn(f"follow {request.goal_id}", self._follow(request))
            self.run.tell("goal", request.path, "sent", request.label, params=request.params)

    # --- until everything has ended

    async def drain(self, limit_s: float, stop: Callable[[], bool] = lambda: False) -> bool:
        """Wait until no goal is under way; False when the limit, or `stop`, came first.

        A device whose contract gives its driver longer to end what was cancelled has so long.
        """
        self._take_back_unsent()
        loop = asyncio.get_running_loop()
        until = loop.time() + max(limit_s, *map(_ends_within_s, self._under_way.values()), 0.0)
        while self.busy:
            self.apply()
            self.run.journal.flush()
            left = until - loop.time()
            if not self.busy:
                break
            if left <= 0 or stop():
                return False
            self.wake.clear()
            handle = loop.call_later(min(left, 1.0), self.wake.set)
            await self.wake.wait()
            handle.cancel()
        self.run.journal.flush()
        return True

    def _take_back_unsent(self) -> None:
        """Goals whose intent did not fit on the disk were not sent, and will never end."""
        for request in [r for r in self._under_way.values() if r.sent_at is None]:
            self._take_back(request)

    def _take_back(self, request: Request) -> None:
        # Its device must not be told: a cancel would block the id for ever, and on resume the
        # same action has the same id.
        del self._under_way[request.goal_id]
        if self._holders.get(request.device) is request:
            del self._holders[request.device]
        request.outcome = CANCELED_BEFORE_SENDING

    def withdraw_all(self) -> None:
        """Cancel everything: the run is being aborted."""
        for request in [*self._queue, *self._under_way.values()]:
            self.withdraw(request)

    async def close(self) -> None:
        """End every task that this dispatcher has started."""
        await end(*self._tasks)

    # --- tasks

    def _spawn(self, name: str, work: Coroutine[Any, Any, None]) -> None:
        task = spawn(name, work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _follow(self, request: Request) -> None:
        client = self.clients[request.device]
        try:
            # An adopted goal is only asked about, not sent: the state may have changed since.
            outcome = await client.follow(
                self._goal(request, client),
                self._heard(request),
                send=request.adopt is None and not request.doubted,
            )
            outcome = await checked_with_server(request, outcome, client, self.run.history)
        except FileFault as fault:
            outcome = _aborted("Rejected", str(fault), "no")
        except Exception as fault:  # an internal error must not leave the tree waiting for ever
            LOG.exception("%s could not be followed", request.goal_id)
            outcome = _aborted("Fault", f"{type(fault).__name__}: {fault}", "unknown")
        self._arrived.append((request, outcome))
        self.wake.set()

    def _goal(self, request: Request, client: DeviceHandle) -> Goal:
        boot = client.boot
        if request.adopt is not None:
            # Where another ledger answers, its silence about the goal proves nothing.
            sent = request.adopt.sent
            boot = sent.boot if self.run.history.is_remembered(sent) else ""
        elif request.doubted:
            boot = ""
        read, _ = request.action.path_params()
        files = {
            name: read_content(self.run.folder, request.params[name])
            for name in read
            if name in request.params
        }
        return Goal(
            id=request.goal_id, device=request.device, boot=boot,
            epoch=client.epoch(request.device), action=request.action_name,
            params=request.params, timeout_s=request.timeout_s, files=files,
        )  # fmt: skip

    def _heard(self, request: Request) -> Callable[[GoalReport], None]:
        def heard(report: GoalReport) -> None:
            if report.mark and request.action.effect == "once":
                self.run.record(j.Marked(device=request.device, mark=report.mark))
                self.run.journal.hand_over()
            if report.state not in ENDED and (report.message or report.progress is not None):
                self.run.tell(
                    "feedback", request.path, report.state, report.message, progress=report.progress
                )

        return heard

    def _cancel(self, request: Request) -> None:
        if request.canceled_at is None:
            request.canceled_at = self.run.clock.now()
            self._spawn(f"cancel {request.goal_id}", self._send_cancel(request))

    async def _send_cancel(self, request: Request) -> None:
        try:
            await self.clients[request.device].cancel(request.goal_id)
        except ServerUnreachable as fault:  # the goal's outcome will show what happened
            self.run.log(f"cancel of {request.label} did not get through: {fault}", request.path)


def _ends_within_s(request: Request) -> float:
    """How long its device may take to end it, by its contract."""
    return request.role.contract.cancel_grace_s + OWN_S


def _at(ago_s: float) -> str:
    """The time of day so long ago."""
    return time.strftime("%H:%M:%S", time.localtime(time.time() - ago_s))


def _has_state(contract: Contract) -> bool:
    return any(action.effect != "pure" for action in contract.actions.values())


def _aborted(name: str, message: str, happened: Happened) -> Outcome:
    error = GoalError(name=name, message=message, happened=happened)
    return Outcome(state="ABORTED", result=None, error=error, files={}, boot="")
