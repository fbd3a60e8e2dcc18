"""Futures waiting for the `ok` of a line: CONTROL repeats each line's text when it is answered."""

import asyncio
import secrets

from ..motion.faults import MotionFault


class Proofs:
    """Lines being waited for. A `next_line` differs from all others, even from those of other clients."""

    def __init__(self) -> None:
        self._waiting: dict[str, asyncio.Future[None]] = {}
        self._word, self._number = secrets.token_hex(3), 0

    def next_line(self) -> str:
        """A dwell of zero time with a unique tag: answered when all earlier motion has ended."""
        self._number += 1
        return f"G4 P0 (labrun {self._word} {self._number})"

    def expect(self, line: str) -> asyncio.Future[None]:
        """A future that ends with the `ok` of exactly this line, or raises a MotionFault."""
        answer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        answer.add_done_callback(_seen)
        self._waiting[line] = answer
        return answer

    def forget(self, line: str) -> None:
        """Stop waiting for it."""
        self._waiting.pop(line, None)

    def answered(self, line: str) -> None:
        """Note that the controller has executed it."""
        answer = self._waiting.pop(line.strip(), None)
        if answer is not None and not answer.done():
            answer.set_result(None)

    def fail(self, fault: MotionFault) -> None:
        """Note that none of them will be answered."""
        waiting, self._waiting = self._waiting, {}
        for answer in waiting.values():
            if not answer.done():
                answer.set_exception(fault)


def _seen(answer: "asyncio.Future[None]") -> None:
    """Mark an exception that nothing waits for as retrieved."""
    if not answer.cancelled():
        answer.exception()
