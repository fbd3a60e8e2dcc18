"""Topics: `subscribe` and `unsubscribe`, with their rate, their size and their encoding.

A client with several subscriptions to one topic gets one stream: the fastest rate, the smallest
fragments, and CBOR if any of them wants it.
"""

import asyncio
from dataclasses import dataclass
from typing import Any

from ....engine.language.suggest import did_you_mean
from ..interfaces.kinds import same_type
from ..offers.offer import Topic, Values
from .client import Client, Message
from .fragments import fragment_size
from .frames import Misformed, as_cbor, may, want

COMPRESSIONS = ("none", "cbor")
MOST_STREAMS = 500


@dataclass(frozen=True, slots=True)
class Wish:
    """One subscription."""

    every_s: float
    size: int | None
    compression: str


class Stream:
    """One client's stream of one topic, under the name that it used."""

    def __init__(self, client: Client, name: str, topic: Topic) -> None:
        self.topic = topic
        self.wishes: dict[str, Wish] = {}
        self._client = client
        self._name = name
        self._sent_at = 0.0
        self._later: asyncio.TimerHandle | None = None
        self._values: Values = {}

    def close(self) -> None:
        """Stop sending."""
        self.topic.leave(self.tell)
        if self._later is not None:
            self._later.cancel()

    def tell(self, values: Values) -> None:
        """The topic has a new message; within the throttle time the latest waits."""
        self._values = values
        if self._later is not None:
            return
        loop = asyncio.get_running_loop()
        wait_s = self._sent_at + min(wish.every_s for wish in self.wishes.values()) - loop.time()
        if wait_s > 0:
            self._later = loop.call_later(wait_s, self._send)
        else:
            self._send()

    def _send(self) -> None:
        self._later = None
        self._sent_at = asyncio.get_running_loop().time()
        message = {"op": "publish", "topic": self._name, "msg": self._values}
        if any(wish.compression == "cbor" for wish in self.wishes.values()):
            self._client.send_bytes(as_cbor(message, self.topic.kind))
        else:
            sizes = [wish.size for wish in self.wishes.values() if wish.size is not None]
            self._client.send(message, min(sizes, default=None), droppable=True)


def subscribe(client: Client, message: Message) -> None:
    """Start sending a topic; the last message is sent at once."""
    name = want(message, "topic", str, "a topic's name")
    topic = client.rooms.topic(name)
    if topic is None:
        hint = did_you_mean(name, client.rooms.offers.topics)
        raise Misformed(f"there is no topic {name}{hint}; rosapi/topics lists them")
    type = message.get("type")
    if type is not None and not same_type(type, topic.kind.type):
        raise Misformed(f"{name} is a {topic.kind.type}, not a {str(type)[:100]}")
    wish = _wish(message)
    stream = client.streams.get(name)
    if stream is None:
        if len(client.streams) >= MOST_STREAMS:
            raise Misformed(f"you already subscribe to {MOST_STREAMS} topics")
        stream = client.streams[name] = Stream(client, name, topic)
        client.closing.append(stream.close)
        stream.wishes[_key(message)] = wish
        topic.listen(stream.tell)
    else:
        stream.wishes[_key(message)] = wish
        if topic.latest is not None:
            stream.tell(topic.latest)


def unsubscribe(client: Client, message: Message) -> None:
    """End one subscription by its id, or all of them to a topic."""
    name = want(message, "topic", str, "a topic's name")
    stream = client.streams.get(name)
    if stream is None:
        raise Misformed(f"you do not subscribe to {name}")
    if message.get("id") is None:
        stream.wishes.clear()
    else:
        stream.wishes.pop(_key(message), None)
    if not stream.wishes:
        stream.close()
        client.closing.remove(stream.close)
        del client.streams[name]


def _wish(message: Message) -> Wish:
    rate_ms = may(message, "throttle_rate", (int, float), "milliseconds", 0)
    may(message, "queue_length", int, "a whole number")
    compression = may(message, "compression", str, "a text", "none")
    if compression not in COMPRESSIONS:
        words = " and ".join(COMPRESSIONS)
        raise Misformed(f"`compression` can be {words} here, not {compression[:40]!r}")
    return Wish(max(0.0, min(rate_ms, 3_600_000)) / 1000, fragment_size(message), compression)


def _key(message: Message) -> str:
    id: Any = message.get("id")
    return "" if id is None else str(id)
