"""Fragmented messages: reassembled on receipt, split if a client wants small ones."""

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from .frames import MOST_BYTES, Misformed, may, want

KEPT_S = 60.0
MOST_OPEN = 16
MOST_PIECES = 20_000
SMALLEST = 64


@dataclass(slots=True)
class _Pieces:
    total: int
    data: dict[int, str] = field(default_factory=dict)
    size: int = 0
    touched: float = field(default_factory=time.monotonic)


class Fragments:
    """The fragments that one client has sent so far; bounded in number, size and time."""

    def __init__(self) -> None:
        self._open: dict[str, _Pieces] = {}

    def take(self, message: dict[str, Any]) -> str | None:
        """Add a fragment; returns the whole text after the last. Raises Misformed."""
        id = str(want(message, "id", (str, int), "a text"))
        data = want(message, "data", str, "a text")
        num = want(message, "num", int, "a whole number")
        total = want(message, "total", int, "a whole number")
        if not (0 < total <= MOST_PIECES and 0 <= num < total):
            raise Misformed(
                f"fragment {num} of {total} is invalid: they count from 0, at most {MOST_PIECES}"
            )
        self._forget()
        if id not in self._open and len(self._open) >= MOST_OPEN:
            raise Misformed(
                f"{MOST_OPEN} messages are already incomplete; finish one of them first"
            )
        pieces = self._open.setdefault(id, _Pieces(total))
        if pieces.total != total or num in pieces.data:
            del self._open[id]
            raise Misformed(f"fragment {num} of message {id} came twice, or has a different total")
        pieces.data[num], pieces.touched = data, time.monotonic()
        pieces.size += len(data)
        if sum(one.size for one in self._open.values()) > MOST_BYTES:
            del self._open[id]
            raise Misformed(f"message {id} is dropped: its fragments exceed {MOST_BYTES} bytes")
        if len(pieces.data) < total:
            return None
        del self._open[id]
        return "".join(pieces.data[index] for index in range(total))

    def _forget(self) -> None:
        over = time.monotonic() - KEPT_S
        for id in [id for id, pieces in self._open.items() if pieces.touched < over]:
            del self._open[id]


def fragment_size(message: dict[str, Any]) -> int | None:
    """The fragment size that a client requests; raises Misformed."""
    size = may(message, "fragment_size", int, "a whole number")
    if size is not None and size < SMALLEST:
        raise Misformed(f"`fragment_size` is {size}, the minimum is {SMALLEST}")
    return size


def cut(text: str, size: int | None, id: str) -> Iterator[str]:
    """The text, or its fragments."""
    if size is None or len(text) <= size:
        yield text
        return
    total = -(-len(text) // size)
    for num in range(total):
        data = text[num * size : (num + 1) * size]
        yield json.dumps({"op": "fragment", "id": id, "data": data, "num": num, "total": total})
