"""The bench that the twins of one lab share: a folder through which they act on each other.

Each twin runs in a process of its own, so what one does to the others (where the gantry stands,
what the pipette let fall on the balance) is a small file that is replaced whole. What a twin
really did is also appended to a log of its own, which no engine and no server can write to. In a
rehearsal all of them are in one process, and nothing of it is written.
"""

import json
import os
import time
from array import array
from collections.abc import Callable, Iterator
from copy import deepcopy
from datetime import UTC, datetime
from io import FileIO
from pathlib import Path
from typing import Any

from ..system.files import write_whole

REFUSALS = 200


class World:
    """Publishes what a device does to the bench, and reads what the others do."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "truth").mkdir(parents=True, exist_ok=True)

    def publish(self, name: str, state: dict[str, Any]) -> None:
        """Publish the state of `name` to all processes; readers see the old or the new one, complete."""
        write_whole(self.folder / f"{name}.json", json.dumps(state).encode(), sync=False)

    def look(self, name: str) -> dict[str, Any] | None:
        """The latest state of `name`; None if none has been published."""
        for _ in range(REFUSALS):
            try:
                return json.loads((self.folder / f"{name}.json").read_bytes())
            except FileNotFoundError:
                return None
            except PermissionError:  # Windows, while it is being replaced
                time.sleep(0.001)
        raise OSError(f"{self.folder / name}.json cannot be read: another program holds it")

    def truth(self, device: str) -> "Truth":
        """The log of what this device really did."""
        return Truth(self.folder / "truth" / f"{device}.jsonl")

    def content(self, make: Callable[[], bytes]) -> bytes:
        """The content of a file that a twin sends."""
        return make()


class Truth:
    """An append-only log, one JSON object a line, numbered by `n` from 1.

    A line is written in one call at the instant when the thing happens. Some twins take it for
    their memory as well: were the two written one after the other, a kill between them would
    make a device that fired and does not know it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: FileIO | None = None
        self._begins = array("q")  # where each line begins in the file

    def open(self) -> None:
        """Find the lines that are there and make ready to append.

        A line torn by a power cut was never reported and is cut off.
        """
        self._file = FileIO(self.path, "a+")
        self._begins, whole = array("q"), 0
        with self.path.open("rb") as lines:
            for line in lines:
                if line.endswith(b"\n"):
                    self._begins.append(whole)
                    whole += len(line)
        self._file.truncate(whole)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def __len__(self) -> int:
        return len(self._begins)

    def append(self, what: str, **facts: Any) -> dict[str, Any]:
        """Write down that it happened, now. The log must be open."""
        at = datetime.now(UTC).isoformat(timespec="milliseconds")
        entry = {"n": len(self) + 1, "at": at, "what": what, **facts}
        if self._file is None:
            raise ValueError(f"the log {self.path.name} is not open")
        begin = self._file.seek(0, os.SEEK_END)
        self._file.write(json.dumps(entry).encode() + b"\n")
        self._begins.append(begin)
        return entry

    def entry(self, n: int) -> dict[str, Any] | None:
        """The line of this number; None where there is none."""
        if not 1 <= n <= len(self):
            return None
        with self.path.open("rb") as lines:
            lines.seek(self._begins[n - 1])
            return json.loads(lines.readline())

    def entries(self) -> Iterator[dict[str, Any]]:
        """All that happened, oldest first; the log need not be open."""
        if not self.path.exists():
            return
        with self.path.open("rb") as lines:
            for line in lines:
                if line.endswith(b"\n"):
                    yield json.loads(line)


class WorldInMemory(World):
    """The bench of a rehearsal; what a file holds is computed where something reads it."""

    def __init__(self) -> None:
        self._published: dict[str, dict[str, Any]] = {}
        self._truths: dict[str, TruthInMemory] = {}
        self._unmade: dict[bytes, Callable[[], bytes]] = {}

    def publish(self, name: str, state: dict[str, Any]) -> None:
        self._published[name] = deepcopy(state)

    def look(self, name: str) -> dict[str, Any] | None:
        return deepcopy(self._published.get(name))

    def truth(self, device: str) -> "TruthInMemory":
        return self._truths.setdefault(device, TruthInMemory(Path(f"{device}.jsonl")))

    def content(self, make: Callable[[], bytes]) -> bytes:
        unmade = f"unmade {len(self._unmade) + 1}".encode()
        self._unmade[unmade] = make
        return unmade

    def is_made(self, content: bytes) -> bool:
        """Whether this is what a file holds, and does not only stand for it."""
        return content not in self._unmade

    def made(self, content: bytes) -> bytes:
        """What a file holds."""
        return content if self.is_made(content) else self._unmade[content]()


class TruthInMemory(Truth):
    """The log of one device in a rehearsal."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._entries: list[dict[str, Any]] = []

    def open(self) -> None:
        pass

    def __len__(self) -> int:
        return len(self._entries)

    def append(self, what: str, **facts: Any) -> dict[str, Any]:
        at = datetime.now(UTC).isoformat(timespec="milliseconds")
        self._entries.append({"n": len(self) + 1, "at": at, "what": what, **deepcopy(facts)})
        return self._entries[-1]

    def entry(self, n: int) -> dict[str, Any] | None:
        return deepcopy(self._entries[n - 1]) if 1 <= n <= len(self) else None

    def entries(self) -> Iterator[dict[str, Any]]:
        return iter(self._entries)
