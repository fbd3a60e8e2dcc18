"""Every short sequence of what can happen to a device, against what must hold whatever happens."""

import asyncio
import contextlib
from pathlib import Path

import pytest

from labrun.drivers.server.lease import Refused
from labrun.drivers.server.ledger import Ledger
from labrun.engine.run.virtual_time import VirtualLoop

from .lamp import Story

pytestmark = pytest.mark.slow

LONG_S = 1000.0


class SlowLedger(Ledger):
    """Each write takes a moment of virtual time, one after the other."""

    def __init__(self):
        super().__init__(Path(":memory:"))
        self._last = None

    def queued(self, work, *args):
        self._last = asyncio.ensure_future(self._write(self._last, work, args))
        return self._last

    async def _write(self, before, work, args):
        if before is not None:
            await asyncio.wait({before})
        await asyncio.sleep(0.3)
        return work(*args)


class Sequence:
    """One device to which a sequence of events happens; `acts` is all that came of it, in order."""

    def __init__(self, ledger, **contract):
        self.story = Story(ledger=ledger, **contract)
        self.device = self.story.device
        self.acts = self.story.lamp.acts
        self.asked = []
        self.epochs = {}
        self.ended = False

    async def run(self, events, pause_s):
        """Let it all happen; returns what could happen next."""
        await self.device.open(make_safe=False)
        await self.story.take("run-0")
        for event in events:
            self._happen(event)
            await asyncio.sleep(pause_s)
        possible = list(self._possible())
        await self._settle()
        await self._end()
        await self.device.close()
        self.story.ledger.close()
        return possible

    def _possible(self):
        yield "stop"
        if not self.ended:
            yield from ("take", "end")
        if self.device.lease.holder is not None:
            yield from ("goal", "release", "lapse", "take again")
        if self.story.lamp.ends:
            yield "goal ends"
        if self.device.running:
            yield "cancel"

    def _happen(self, event):
        lease = self.device.lease
        match event:
            case "take":
                self._ask(self.story.take(f"run-{len(self.asked)}"))
            case "take again":
                self._ask(self.story.take(lease.holder.owner))
            case "goal":
                self._ask(self._goal(lease.holder.epoch))
            case "release":
                self._ask(self._release(lease.holder))
            case "lapse":
                self.acts.append(("lease over", lease.holder.epoch))
                lease.holder.timer.cancel()
                lease._lapse()
            case "goal ends":
                next(iter(self.story.lamp.ends.values())).set()
            case "cancel":
                next(iter(self.device.running.values())).cancel()
            case "stop":
                self.acts.append(("stop", ""))
                self._ask(self._stop())
            case "end":
                self.ended = True
                self._ask(self._end())

    def _ask(self, request):
        async def asked():
            with contextlib.suppress(Refused):
                await request

        self.asked.append(asyncio.ensure_future(asked()))

    async def _release(self, holder):
        if await self.device.release(holder.owner, holder.epoch):
            self.acts.append(("lease over", holder.epoch))

    async def _goal(self, epoch):
        goal = f"g{len(self.epochs) + 1}"
        self.epochs[goal] = epoch
        await self.story.goal(epoch, goal)

    async def _stop(self):
        self.acts.append(("answered", await self.device.stop(LONG_S)))

    async def _end(self):
        self.acts.append(("end", ""))
        await self.device.wind_down()

    async def _settle(self):
        """What was asked for comes to an end, and the device can be used again."""
        await asyncio.sleep(20.0)
        for end in list(self.story.lamp.ends.values()):
            end.set()
        await asyncio.sleep(20.0)
        assert all(one.done() for one in self.asked), "a request, or a stop, is lost"
        for one in self.asked:
            one.result()
        assert not self.device.running, "a goal does not end"
        holder = self.device.lease.holder
        if self.ended:
            assert holder is None, "a lease is granted after the end"
        else:
            known = "lamp" in self.story.ledger.abandoned()
            assert known or holder is None, "a crash would not be seen to leave it held"
            await self.story.take(holder.owner if holder else "run-z")
            await self._goal(self.device.lease.holder.epoch)
            await asyncio.sleep(1.0)
            assert self.acts[-1] == ("begins", f"g{len(self.epochs)}"), "no goal begins any more"

    def check(self, *, aborting):
        """What must hold; `aborting` are the events that abort what acts at once."""
        acting, over, safe_calls, lapsed, urgent = {}, {}, [], {}, 0
        for n, (act, which) in enumerate(self.acts):
            now_safe = bool(safe_calls) and safe_calls[-1][1] is None
            urgent += act in aborting
            match act:
                case "begins":
                    assert not acting, "two exclusive goals at once"
                    assert not now_safe, "a goal begins under safe()"
                    assert ("end", "") not in self.acts[:n], "a goal begins after the end"
                    epoch = self.epochs[which]
                    assert epoch not in lapsed, "a goal begins whose lease is over"
                    for goal, when in over.items():
                        since = lapsed.get(self.epochs[goal])
                        if since is not None and since < when:
                            made = any(began > when for began, _ in safe_calls)
                            assert made, "a goal begins before a lapse was made safe"
                    acting[which] = n
                case "over":
                    del acting[which]
                    over[which] = n
                case "lease over":
                    lapsed[which] = n
                case "safe":
                    assert not now_safe, "two safe() at once"
                    urgent -= bool(acting)
                    assert urgent >= 0, "safe() under a goal that nobody aborted"
                    safe_calls.append([n, None])
                case "safe over":
                    safe_calls[-1][1] = n
                case "answered":
                    assert which[0] and not acting, "safe is answered while a goal acts"
                    began = max(b for b, end in safe_calls if end is not None)
                    assert began > max(over.values(), default=-1), "safe() was before the last act"


async def every_sequence(length, lapse, pause_s):
    """Run every possible sequence, each as the continuation of a shorter one; returns how many."""
    aborting = {"stop", "end"} | ({"lease over"} if lapse == "safe" else set())
    shorter, count = [()], 0
    for n in range(length + 1):
        longer = []
        for events in shorter:
            ledger = SlowLedger() if pause_s else Ledger(Path(":memory:"))
            sequence = Sequence(ledger, on_lease_lapse=lapse)
            try:
                possible = await sequence.run(events, pause_s)
                sequence.check(aborting=aborting)
            except AssertionError as fault:
                raise AssertionError(f"{fault}: {events} -> {sequence.acts}") from fault
            count += 1
            longer += [(*events, event) for event in possible] if n < length else []
        shorter = longer
    return count


@pytest.mark.parametrize(
    "pause_s",
    [
        0.0,
        pytest.param(0.2, marks=pytest.mark.soak),
        pytest.param(0.5, marks=pytest.mark.soak),
        2.0,
    ],
)
@pytest.mark.parametrize("lapse", ["finish", "cancel", "safe"])
@pytest.mark.parametrize(
    "length",
    [
        3,
        pytest.param(4, marks=pytest.mark.soak),
        pytest.param(5, marks=[pytest.mark.soak, pytest.mark.timeout(600)]),
    ],
)
def test_whatever_happens_to_a_device_one_owner_keeps_it_in_order(length, lapse, pause_s):
    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        count = runner.run(every_sequence(length, lapse, pause_s))

    assert count > 3**length
