"""The headers of a command: its key, its control lease, and its deadline."""

import time
from dataclasses import dataclass
from typing import Annotated
from urllib.parse import unquote

from fastapi import Depends, Header, Request

from ..local.refusal import Refusal

LONGEST_MS = 60_000.0
LONGEST_NAME = 80

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=8,
        max_length=128,
        description="New for each click. Repeating a key returns the same answer and does nothing.",
    ),
]
Until = Annotated[
    float | None,
    Header(
        alias="X-Deadline",
        description="Milliseconds since 1970 by the server's clock (`server_time_ms`): after this the "
        "command is refused with 408 and not done. At most 60 s ahead.",
    ),
]
Name = Annotated[
    str,
    Header(
        alias="X-Name", max_length=1000,
        description="Who stops or pauses, percent-encoded; for the log, and needed for nothing.",
    ),
]  # fmt: skip
ControlLease = Annotated[
    str | None,
    Header(alias="X-Control-Lease", description="From `POST /control/take`; 423 without it."),
]


@dataclass(frozen=True, slots=True)
class Deadline:
    """The time after which a command must not start; None: no limit."""

    until_ms: float | None = None

    def check(self) -> None:
        """Raise Refusal (408) after the deadline: a command that waited too long is not done."""
        if self.until_ms is not None and time.time() * 1000 > self.until_ms:
            late_s = time.time() - self.until_ms / 1000
            raise Refusal(
                408, "LATE", f"the command arrived {late_s:.1f} s after its deadline and was not done",
                "check the present state, and try again if you still want it",
            )  # fmt: skip


async def in_time(until: Until = None) -> Deadline:
    """The deadline of a command, checked; required."""
    if until is None:
        raise Refusal(400, "NO_DEADLINE", "a command needs the header X-Deadline")
    return _deadline(until)


async def perhaps_in_time(until: Until = None) -> Deadline:
    """The deadline, if given: a stop and a pause need none."""
    return Deadline() if until is None else _deadline(until)


def _deadline(until_ms: float) -> Deadline:
    ahead = until_ms - time.time() * 1000
    if not ahead < LONGEST_MS:  # false for NaN, too
        raise Refusal(
            400, "FAR_DEADLINE", "X-Deadline is more than 60 s ahead of the server's clock",
            "it is in milliseconds by `server_time_ms` of GET /session",
        )  # fmt: skip
    deadline = Deadline(until_ms)
    deadline.check()
    return deadline


def by_whom(name: str, how: str) -> str:
    """Who says to be `name`, and `how`; nobody has to say who they are."""
    said = " ".join("".join(c for c in name if c.isprintable()).split())[:LONGEST_NAME]
    return f"{said} ({how})" if said else how


async def by_name(name: Name = "") -> str:
    """Who acts on the page, as the log says it."""
    return by_whom(unquote(name), "the page")


async def by_holder(request: Request, lease: ControlLease = None) -> str:
    """The name of the holder of control, which this renews; 423 for everybody else."""
    return request.app.state.app_state.control.used_by(lease)


async def needs_key(key: Key = None) -> str:
    """The key of a command; required."""
    if key is None:
        raise Refusal(400, "NO_KEY", "a command needs the header Idempotency-Key")
    return key


InTime = Annotated[Deadline, Depends(in_time)]
PerhapsInTime = Annotated[Deadline, Depends(perhaps_in_time)]
ByName = Annotated[str, Depends(by_name)]
Operator = Annotated[str, Depends(by_holder)]
CommandKey = Annotated[str, Depends(needs_key)]
