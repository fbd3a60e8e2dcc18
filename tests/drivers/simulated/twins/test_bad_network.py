"""The bad network to order: what it lets through is whole, and every fault that is ordered happens."""

import asyncio
import socket
from contextlib import asynccontextmanager

import pytest

from labrun.drivers.server.listen import bind, listening
from labrun.drivers.simulated.twins.bad_network import FaultyWire, Packing, WireFaults

SPECTRUM = bytes(range(256)) * 356


class Peer:
    """A Socket.IO server that writes down what reaches it and echoes it."""

    def __init__(self, ping_s=300, patience_s=300):
        import socketio

        self.heard = []
        self.sessions = []
        self.sio = socketio.AsyncServer(
            async_mode="asgi",
            transports=["websocket"],
            ping_interval=ping_s,
            ping_timeout=patience_s,
        )
        self.app = socketio.ASGIApp(self.sio)
        self.sio.on("connect", self._connected, namespace="/action")
        self.sio.on("say", self._said, namespace="/action")

    async def _connected(self, session, environ, auth=None):
        self.sessions.append(session)

    async def _said(self, session, data):
        self.heard.append(data["n"])
        return data


@asynccontextmanager
async def served(**more):
    peer, listener = Peer(**more), bind("127.0.0.1", 0)
    url = f"http://127.0.0.1:{listener.getsockname()[1]}"
    async with listening(peer.app, listener):
        try:
            yield peer, url
        finally:
            await peer.sio.shutdown()


@asynccontextmanager
async def wired(ping_s=300, patience_s=300, **faults):
    async with served(ping_s=ping_s, patience_s=patience_s) as (peer, target):
        wire = FaultyWire(target, WireFaults(**faults))
        await wire.open()
        try:
            yield peer, wire
        finally:
            await wire.close()


class Caller:
    """A bare client that notes what it hears, and in which order."""

    def __init__(self, session):
        import socketio

        self.session = session
        self.sio = socketio.AsyncClient(
            reconnection=False, handle_sigint=False, http_session=session
        )
        self.heard = []
        self.broken = asyncio.Event()
        self.sio.on("told", lambda data: self.heard.append(data["n"]), namespace="/action")
        self.sio.on("disconnect", lambda reason: self.broken.set(), namespace="/action")
        self.acks = []

    async def say(self, n, **more):
        await self.sio.emit("say", {"n": n, **more}, namespace="/action", callback=self.acks.append)


@asynccontextmanager
async def calling(url):
    import aiohttp

    async with aiohttp.ClientSession() as session:
        caller = Caller(session)
        await caller.sio.connect(url, transports=["websocket"], namespaces=["/action"])
        line = caller.sio.eio.ws
        try:
            yield caller
        finally:
            await caller.sio.disconnect()
            await session.close()
            await line.close()  # python-engineio forgets one that broke


async def connect_and_leave(url):
    async with calling(url):
        pass


async def until(true):
    async with asyncio.timeout(500):
        while not true():  # noqa: ASYNC110 - what it waits for has no event
            await asyncio.sleep(0.005)


async def settled(heard):
    """Wait until nothing more arrives."""
    async with asyncio.timeout(500):
        before = -1
        while before != len(heard):
            before = len(heard)
            await asyncio.sleep(0.5)


def test_a_message_is_whole_when_all_of_its_bytes_are_there():
    packing = Packing()
    head = '452-/action,["copy",{"_placeholder":true,"num":0},{"_placeholder":true,"num":1}]'
    made = [packing.add(frame) for frame in (head, b"one", "2", b"two", '43/action,7["ok"]')]

    assert [None if packet is None else packet.frames for packet in made] == [
        None,
        None,
        ("2",),
        (head, b"one", b"two"),
        ('43/action,7["ok"]',),
    ]


@pytest.mark.parametrize(
    ("frame", "kind"),
    [
        ('42/action,7["goal",{"id":"r/1"}]', "event"),
        ('42["goal"]', "event"),
        ('451-/action,["update",{"_placeholder":true,"num":0}]', "event"),
        ('43/action,7[{"ok":true}]', "ack"),
        ('461-/action,7[{"_placeholder":true,"num":0}]', "ack"),
        ("40/action,{}", "other"),
        ("41/action,", "other"),
        ('44/action,"the token is wrong"', "other"),
        ("2", "other"),
        ("3", "other"),
    ],
)
def test_handshakes_and_pings_are_told_from_what_may_be_lost(frame, kind):
    packing = Packing()
    packet = packing.add(frame)
    packet = packing.add(b"bytes") if packet is None else packet

    assert packet.kind == kind


def test_a_wire_without_faults_changes_nothing():
    async def story():
        async with wired() as (peer, wire), calling(wire.url) as caller:
            for n in range(50):
                await caller.say(n, spectrum=SPECTRUM)
            await until(lambda: len(caller.acks) == 50)
            for n in range(50):
                await peer.sio.emit("told", {"n": n, "spectrum": SPECTRUM}, namespace="/action")
            await until(lambda: len(caller.heard) == 50)
            return peer.heard, caller, wire.done

    heard, caller, done = asyncio.run(story())

    assert heard == caller.heard == list(range(50))
    assert caller.acks == [{"n": n, "spectrum": SPECTRUM} for n in range(50)]
    assert not done


def test_lost_requests_are_missing_and_all_others_are_answered():
    async def story():
        async with wired(drop_request=0.3) as (peer, wire), calling(wire.url) as caller:
            for n in range(100):
                await caller.say(n, spectrum=SPECTRUM)
            await until(lambda: len(caller.acks) + wire.done["drop_request"] == 100)
            return peer.heard, caller.acks, wire.done

    heard, acks, done = asyncio.run(story())

    assert done == {"drop_request": 100 - len(heard)}
    assert 10 < done["drop_request"] < 60
    assert [ack["n"] for ack in acks] == heard == sorted(heard)
    assert all(ack["spectrum"] == SPECTRUM for ack in acks)


def test_lost_replies_are_missing_though_every_request_arrived():
    async def story():
        async with wired(drop_reply=0.3) as (peer, wire), calling(wire.url) as caller:
            for n in range(60):
                await caller.say(n, spectrum=SPECTRUM)
                await peer.sio.emit("told", {"n": n, "spectrum": SPECTRUM}, namespace="/action")
            await until(
                lambda: len(caller.acks) + len(caller.heard) + wire.done["drop_reply"] == 120
            )
            return peer.heard, caller, wire.done

    heard, caller, done = asyncio.run(story())

    assert heard == list(range(60))
    assert done == {"drop_reply": 120 - len(caller.acks) - len(caller.heard)}
    assert len(caller.acks) < 60
    assert len(caller.heard) < 60


def test_duplicates_arrive_twice_and_whole():
    async def story():
        async with wired(duplicate=0.5) as (peer, wire), calling(wire.url) as caller:
            for n in range(60):
                await caller.say(n, spectrum=SPECTRUM)
            await until(lambda: len(caller.acks) == 60)
            await settled(peer.heard)
            return peer.heard, caller.acks, wire.done

    heard, acks, done = asyncio.run(story())
    twice = [n for n in set(heard) if heard.count(n) == 2]

    assert set(heard) == set(range(60))
    assert len(heard) == 60 + len(twice)
    assert 0 < len(twice) < done["duplicate"]  # the rest were answers, which the client counts once
    assert sorted(ack["n"] for ack in acks) == list(range(60))


def test_what_is_held_back_is_overtaken_and_still_arrives_whole():
    async def story():
        async with wired(reorder=0.3) as (peer, wire), calling(wire.url) as caller:
            for n in range(60):
                await caller.say(n, spectrum=SPECTRUM)
            await until(lambda: len(caller.acks) == 60)
            return peer.heard, caller.acks, wire.done

    heard, acks, done = asyncio.run(story())

    assert done["reorder"] > 0
    assert heard != sorted(heard)
    assert sorted(heard) == list(range(60))
    assert all(ack["spectrum"] == SPECTRUM for ack in acks)


def test_the_same_seed_loses_the_same_and_another_seed_other_things():
    async def story(seed):
        async with wired(seed=seed, drop_request=0.3) as (peer, wire):
            for connection in (1, 2):
                async with calling(wire.url) as caller:
                    for n in range(40):
                        await caller.say(n)
                    said = 40 * connection
                    await until(lambda: len(peer.heard) + wire.done["drop_request"] == said)  # noqa: B023
            return peer.heard

    first, again, other = (asyncio.run(story(seed)) for seed in (1, 1, 2))

    assert first == again
    assert first != other
    assert first[: len(first) // 2] != first[len(first) // 2 :]


def test_a_hang_holds_the_pings_too_and_then_all_goes_on_in_order():
    async def story():
        wiring = wired(ping_s=0.05, hang=1.0, hang_s=0.25)
        async with wiring as (peer, wire), calling(wire.url) as caller:
            begun = asyncio.get_running_loop().time()
            for n in range(5):
                await caller.say(n)
            await until(lambda: len(peer.heard) == 5)
            return peer.heard, asyncio.get_running_loop().time() - begun, wire.done

    heard, took_s, done = asyncio.run(story())

    assert heard == list(range(5))
    assert took_s > 0.2
    assert done["hang"] >= 5


def test_a_hang_that_outlasts_the_pings_breaks_the_connection():
    async def story():
        wiring = wired(ping_s=0.5, patience_s=0.5, hang=1.0, hang_s=600)
        async with wiring as (_, wire), calling(wire.url) as caller:
            await caller.say(1)
            async with asyncio.timeout(500):
                await caller.broken.wait()
            return caller.acks

    assert asyncio.run(story()) == []


def test_a_cut_by_chance_breaks_the_connection_and_the_next_one_works():
    async def story():
        async with wired(cut=1.0) as (peer, wire):
            async with calling(wire.url) as caller:
                await caller.say(1)
                async with asyncio.timeout(500):
                    await caller.broken.wait()
            wire.faults = WireFaults()
            async with calling(wire.url) as caller:
                await caller.say(2)
                await until(lambda: caller.acks)
            return peer.heard, wire.done

    heard, done = asyncio.run(story())

    assert heard == [2]
    assert done == {"cut": 1}


def test_a_cut_on_demand_breaks_every_connection():
    async def story():
        async with wired() as (_, wire), calling(wire.url) as one, calling(wire.url) as two:
            wire.cut()
            async with asyncio.timeout(500):
                await one.broken.wait()
                await two.broken.wait()
            return wire.done

    assert not asyncio.run(story())


def test_a_frozen_wire_lets_nobody_in_and_nothing_through_until_it_thaws():
    async def story():
        async with wired() as (peer, wire), calling(wire.url) as caller:
            wire.freeze(600)
            await caller.say(1)
            connecting = asyncio.create_task(connect_and_leave(wire.url))
            await asyncio.sleep(0.2)
            frozen = list(peer.heard), len(peer.sessions)
            wire.stillness.end()
            await until(lambda: peer.heard)
            await connecting
            return frozen, peer.heard, len(peer.sessions)

    frozen, heard, sessions = asyncio.run(story())

    assert frozen == ([], 1)
    assert (heard, sessions) == ([1], 2)


def test_a_caller_who_gave_up_before_the_thaw_leaves_no_trace(capfd):
    async def story():
        async with wired() as (peer, wire):
            wire.freeze(600)
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.1):
                    await connect_and_leave(wire.url)
            wire.stillness.end()
            await asyncio.sleep(0.2)
            async with calling(wire.url):
                return len(peer.sessions)

    assert asyncio.run(story()) == 1
    assert capfd.readouterr() == ("", "")


def test_nothing_passes_after_a_cut_that_was_already_on_its_way():
    async def story():
        async with wired() as (peer, wire), calling(wire.url) as caller:
            wire.freeze(600)
            for n in range(20):
                await caller.say(n)
            await asyncio.sleep(0.1)
            wire.cut()
            wire.stillness.end()
            async with asyncio.timeout(500):
                await caller.broken.wait()
            await asyncio.sleep(0.2)
            return peer.heard

    assert asyncio.run(story()) == []


def test_what_was_said_before_the_caller_left_still_arrives_after_a_freeze():
    async def story():
        async with wired() as (peer, wire):
            async with calling(wire.url) as caller:
                wire.freeze(600)
                await caller.say(1)
                await asyncio.sleep(0.1)
                await caller.session.close()
            frozen = list(peer.heard)
            wire.stillness.end()
            await until(lambda: peer.heard)
            return frozen, peer.heard

    assert asyncio.run(story()) == ([], [1])


def test_a_server_that_is_not_there_closes_the_connection_and_the_next_target_is_reached(capfd):
    from socketio.exceptions import ConnectionError as Unconnected

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        nobody = f"http://127.0.0.1:{probe.getsockname()[1]}"

    async def story():
        async with served() as (peer, target):
            wire = FaultyWire(nobody, WireFaults())
            await wire.open()
            try:
                with pytest.raises(Unconnected):
                    async with calling(wire.url):
                        pass
                wire.target = target
                async with calling(wire.url) as caller:
                    await caller.say(1)
                    await until(lambda: caller.acks)
            finally:
                await wire.close()
            return peer.heard

    assert asyncio.run(story()) == [1]
    assert capfd.readouterr() == ("", "")


def test_a_request_that_is_no_websocket_is_turned_away(capfd):
    import aiohttp

    async def story():
        async with (
            wired() as (_, wire),
            aiohttp.ClientSession() as session,
            session.get(wire.url) as answer,
        ):
            return answer.status, await answer.text()

    assert asyncio.run(story()) == (400, "only WebSocket passes here\n")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("frozen", [False, True])
def test_a_closed_wire_leaves_no_task_and_frees_its_port(frozen, capfd):
    async def story():
        async with served() as (_, target):
            before = asyncio.all_tasks()
            wire = FaultyWire(target, WireFaults(reorder=1.0))
            await wire.open()
            async with calling(wire.url) as caller:
                await caller.say(1)
                if frozen:
                    wire.freeze(600)
                    await caller.say(2)
                    waiting = asyncio.create_task(connect_and_leave(wire.url))
                    await asyncio.sleep(0.1)
                await wire.close()
                async with asyncio.timeout(500):
                    await caller.broken.wait()
                if frozen:
                    await asyncio.gather(waiting, return_exceptions=True)
            bind("127.0.0.1", int(wire.url.rpartition(":")[2])).close()
            await asyncio.sleep(0)
            return [task for task in asyncio.all_tasks() - before if "twins/wire" in repr(task)]

    assert asyncio.run(story()) == []
    assert capfd.readouterr() == ("", "")
