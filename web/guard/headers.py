"""The headers of a command: its key, who has control, and until when it may be done."""

import time
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Header, Request

from .refusal import Refusal

LONGEST_MS = 60_000.0

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=8,
        max_length=128,
        description="New for each click. The same key again gives the same answer and does nothing.",
    ),
]
Until = Annotated[
    float | None,
    Header(
        alias="X-Deadline",
        description="Milliseconds since 1970 by the server's clock (`server_time_ms`): after it the "
        "command is refused with 408 and not done. At most 60 s ahead.",
    ),
]
ControlLease = Annotated[
    str | None,
    Header(alias="X-Control-Lease", description="From `POST /control/take`; 423 without it."),
]


@dataclass(frozen=True, slots=True)
class Deadline:
    """The instant after which a command must not be begun; None: it may wait."""

    until_ms: float | None = None

    def check(self) -> None:
        """Raise Refusal (408) when it is over: what waited too long is not done any more."""
        if self.until_ms is not None and time.time() * 1000 > self.until_ms:
            late_s = time.time() - self.until_ms / 1000
            raise Refusal(
                408, "LATE", f"it came {late_s:.1f} s after its deadline and was not done",
                "look at the present state, and ask again if you still want it",
            )  # fmt: skip


def in_time(until: Until = None) -> Deadline:
    """The deadline of a command, checked; one is needed."""
    if until is None:
        raise Refusal(400, "NO_DEADLINE", "a command needs the header X-Deadline")
    return _deadline(until)


def perhaps_in_time(until: Until = None) -> Deadline:
    """The deadline where one is given: a stop and a pause need none."""
    return Deadline() if until is None else _deadline(until)


def _deadline(until_ms: float) -> Deadline:
    ahead = until_ms - time.time() * 1000
    if not ahead < LONGEST_MS:  # false for NaN, too
        raise Refusal(
            400, "FAR_DEADLINE", "X-Deadline is more than 60 s ahead of the server's clock",
            "it counts in milliseconds by `server_time_ms` of GET /session",
        )  # fmt: skip
    deadline = Deadline(until_ms)
    deadline.check()
    return deadline


def by_holder(request: Request, lease: ControlLease = None) -> str:
    """The name of whoever has control; 423 for everybody else. It is renewed by this."""
    return request.app.state.site.control.used_by(lease)


def needs_key(key: Key = None) -> str:
    """The key of a command; one is needed."""
    if key is None:
        raise Refusal(400, "NO_KEY", "a command needs the header Idempotency-Key")
    return key


InTime = Annotated[Deadline, Depends(in_time)]
PerhapsInTime = Annotated[Deadline, Depends(perhaps_in_time)]
Operator = Annotated[str, Depends(by_holder)]
CommandKey = Annotated[str, Depends(needs_key)]
