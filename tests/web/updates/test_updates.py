"""One source that fails neither silences the push nor starves the other sources."""

import asyncio
from contextlib import asynccontextmanager

import socketio

from labrun.drivers.server.listen import bind, listening
from labrun.web.models.control import ControlState
from labrun.web.models.runs import LaunchState
from labrun.web.updates.updates import NAMESPACE, Source, Sources, Updates


class Launches:
    """A source with some launches; `broken` names those whose state cannot be told."""

    def __init__(self, *names):
        self.names = list(names)
        self.broken = set()

    def one(self, name):
        if name in self.broken:
            raise RuntimeError(f"dictionary changed size during iteration of {name}")
        return LaunchState(id=name, run=None, state="starting") if name in self.names else None


@asynccontextmanager
async def told(launches):
    """The updates of a server on loopback, and a queue of what one browser is told."""
    updates, events = Updates(), asyncio.Queue()
    nothing = Source(list, lambda name: None)
    kinds = dict.fromkeys(("devices", "runs", "goals", "jogs"), nothing)
    sources = Sources(
        kinds={**kinds, "launches": Source(lambda: launches.names, launches.one)},
        control=ControlState, bench=lambda: "bench", signed_in=lambda environ: True,
        watch=None, beat=None, session_closed=lambda session: None, stop=None,
    )  # fmt: skip
    updates.open(sources)
    listener = bind("127.0.0.1", 0)
    sio = socketio.AsyncClient(reconnection=False, handle_sigint=False)
    for event in ("snapshot", "patch"):
        sio.on(event, lambda data, e=event: events.put_nowait((e, data)), namespace=NAMESPACE)
    try:
        async with listening(socketio.ASGIApp(updates.sio), listener):
            url = f"http://127.0.0.1:{listener.getsockname()[1]}"
            await sio.connect(url, transports=["websocket"], namespaces=[NAMESPACE])
            yield updates, events
            await sio.disconnect()
    finally:
        await updates.close()
        listener.close()


async def get(events):
    async with asyncio.timeout(500):
        return await events.get()


def test_a_source_that_fails_once_is_logged_and_told_with_the_next_patch(caplog):
    async def story():
        launches = Launches("good", "bad")
        async with told(launches) as (updates, events):
            await get(events)
            launches.broken.add("bad")
            updates.touch("launches", "bad")
            updates.touch("launches", "good")
            first = await get(events)
            launches.broken.clear()
            updates.touch("launches", "good")
            return first, await get(events)

    (_, first), (_, second) = asyncio.run(story())

    assert set(first["launches"]) == {"good"}
    assert set(second["launches"]) == {"good", "bad"} and second["seq"] == first["seq"] + 1
    (record,) = [record for record in caplog.records if record.name == "labrun"]
    assert "bad" in record.getMessage() and "changed size" in str(record.exc_info[1])


def test_a_snapshot_leaves_out_only_what_cannot_be_told(caplog):
    async def story():
        launches = Launches("good", "bad")
        launches.broken.add("bad")
        async with told(launches) as (_, events):
            return await get(events)

    event, snapshot = asyncio.run(story())

    assert event == "snapshot" and set(snapshot["launches"]) == {"good"}
    assert [record.exc_info[0] for record in caplog.records if record.name == "labrun"] == [
        RuntimeError
    ]
