"""Have many spectra reduced: in chunks, a bounded number at a time, each twice at the most."""

from collections import deque
from collections.abc import Callable, Iterable

from .crew import Answer, Chunk, Crew
from .source import Source
from .spool import Spool
from .work import Done, failed

MOST_IN_CHUNK = 8
CHUNKS_A_WORKER = 4  # at least, so that none waits long for the last one
WAIT_S = 0.5

Watching = Callable[[Done], None]


class Batch:
    """What is to be reduced, what is under way, and where it goes."""

    def __init__(self, crew: Crew, spool: Spool, watching: Watching = lambda done: None) -> None:
        self.crew = crew
        self.spool = spool
        self.watching = watching
        self.waiting: deque[Chunk] = deque()
        self.under_way: dict[int, Chunk] = {}
        self.again: set[str] = set()
        self.number = 0

    def add(self, sources: Iterable[Source]) -> None:
        """Queue spectra, in chunks that keep every worker busy."""
        todo = list(sources)
        each = -(-len(todo) // (self.crew.room * CHUNKS_A_WORKER))
        each = max(min(each, MOST_IN_CHUNK), 1)
        self.waiting.extend(todo[at : at + each] for at in range(0, len(todo), each))

    @property
    def busy(self) -> bool:
        """Whether anything is queued or under way."""
        return bool(self.waiting or self.under_way)

    def run(self) -> None:
        """Go on until nothing is left. Raises CrewFault, or OSError where the disk is full."""
        while self.busy:
            self.step(WAIT_S)

    def step(self, wait_s: float) -> None:
        """Give out what there is room for, and take in what was answered within that time."""
        while self.waiting and len(self.under_way) < self.crew.room:
            self.number += 1
            self.under_way[self.number] = chunk = self.waiting.popleft()
            self.crew.start(self.number, chunk)
        for answer in self.crew.answers(wait_s):
            self._take(answer)

    def _take(self, answer: Answer) -> None:
        chunk = self.under_way.pop(answer.number)
        if not answer.lost:
            for done in answer.done:
                self._keep(done)
            return
        # Which of them did it is not known: each once more, by itself, and the guilty one is told.
        for source in chunk:
            if source.name in self.again:
                self._keep(failed(source.name, f"{answer.lost}, twice"))
            else:
                self.again.add(source.name)
                self.waiting.appendleft([source])

    def _keep(self, done: Done) -> None:
        self.spool.put(done)
        self.watching(done)
