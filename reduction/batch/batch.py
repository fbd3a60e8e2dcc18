"""Reduce many spectra: in chunks, a bounded number at a time, each at most twice."""

from collections import deque
from collections.abc import Callable, Iterable

from .executor import Answer, Chunk, Executor
from .source import Source
from .spool import Spool
from .work import Done, failed

MOST_IN_CHUNK = 8
CHUNKS_A_WORKER = 4  # at least, so that none waits long for the last chunk
WAIT_S = 0.5

Watching = Callable[[Done], None]


class Batch:
    """What is queued, what is under way, and where results go."""

    def __init__(
        self, executor: Executor, spool: Spool, watching: Watching = lambda done: None
    ) -> None:
        self.executor = executor
        self.spool = spool
        self.watching = watching
        self.waiting: deque[Chunk] = deque()
        self.under_way: dict[int, Chunk] = {}
        self.again: set[str] = set()
        self.number = 0

    def add(self, sources: Iterable[Source]) -> None:
        """Queue spectra, in chunks that keep every worker busy."""
        todo = list(sources)
        each = -(-len(todo) // (self.executor.room * CHUNKS_A_WORKER))
        each = max(min(each, MOST_IN_CHUNK), 1)
        self.waiting.extend(todo[at : at + each] for at in range(0, len(todo), each))

    @property
    def busy(self) -> bool:
        """Whether anything is queued or under way."""
        return bool(self.waiting or self.under_way)

    def run(self) -> None:
        """Run until nothing is left. Raises ExecutorFault, or OSError if the disk is full."""
        while self.busy:
            self.step(WAIT_S)

    def step(self, wait_s: float) -> None:
        """Hand out chunks while there is room, and collect what is answered within that time."""
        while self.waiting and len(self.under_way) < self.executor.room:
            self.number += 1
            self.under_way[self.number] = chunk = self.waiting.popleft()
            self.executor.start(self.number, chunk)
        for answer in self.executor.answers(wait_s):
            self._take(answer)

    def _take(self, answer: Answer) -> None:
        chunk = self.under_way.pop(answer.number)
        if not answer.lost:
            for done in answer.done:
                self._keep(done)
            return
        # The culprit is not known: retry each by itself, and report the one that fails.
        for source in chunk:
            if source.name in self.again:
                self._keep(failed(source.name, f"{answer.lost}, twice"))
            else:
                self.again.add(source.name)
                self.waiting.appendleft([source])

    def _keep(self, done: Done) -> None:
        self.spool.put(done)
        self.watching(done)
