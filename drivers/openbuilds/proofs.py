"""Who waits for the `ok` of which line: CONTROL tells each line's own text when it is answered."""

import asyncio
import secrets

from ..grbl.faults import GrblFault


class Proofs:
    """Lines that somebody waits for. A `next_line` is told from all others, of other clients too."""

    def __init__(self) -> None:
        self._waiting: dict[str, asyncio.Future[None]] = {}
        self._word, self._number = secrets.token_hex(3), 0

    def next_line(self) -> str:
        """A dwell of no time with a name of its own: answered when all earlier motion has ended."""
        self._number += 1
        return f"G4 P0 (labrun {self._word} {self._number})"

    def expect(self, line: str) -> asyncio.Future[None]:
        """A future that ends with the `ok` of exactly this line, or raises a GrblFault."""
        answer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        answer.add_done_callback(_seen)
        self._waiting[line] = answer
        return answer

    def forget(self, line: str) -> None:
        """Nobody waits for it any more."""
        self._waiting.pop(line, None)

    def answered(self, line: str) -> None:
        """The controller has done it."""
        answer = self._waiting.pop(line.strip(), None)
        if answer is not None and not answer.done():
            answer.set_result(None)

    def fail(self, fault: GrblFault) -> None:
        """None of them will be answered."""
        waiting, self._waiting = self._waiting, {}
        for answer in waiting.values():
            if not answer.done():
                answer.set_exception(fault)


def _seen(answer: "asyncio.Future[None]") -> None:
    """A fault that nobody waited for is no leak."""
    if not answer.cancelled():
        answer.exception()
