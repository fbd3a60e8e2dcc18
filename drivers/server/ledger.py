"""The durable memory of a device server: every goal, before and after it touches a device.

A goal is on disk before the driver is called, its outcome before it is reported; so after a crash
the server can state for every goal whether it never began, was interrupted, or how it ended.

Every change is chained to the one before by a hash. Its newest link is the ledger's mark: a ledger
that lacks a mark which it once gave was replaced by an older copy, and what it does not contain may
have happened all the same.
"""

import asyncio
import itertools
import json
import os
import secrets
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from hashlib import blake2b
from pathlib import Path
from typing import Any, ClassVar, TypeVar, TypeVarTuple

from ...schemas.messages import FileContent, Goal, GoalError, GoalReport, GoalState
from .newest_mark import NewestMark
from .thread_queue import ThreadQueue

Args = TypeVarTuple("Args")
T = TypeVar("T")

KEPT_FILES = 64
"""Goals whose files stay in the ledger; of older goals only the result is kept."""

LOCK_S = 2.0
"""How long to wait for a server that is shutting down to release the file."""

OPEN = ("ACCEPTED", "EXECUTING", "CANCELING")

TABLES = """
CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS goals (
    id TEXT PRIMARY KEY, seq INTEGER NOT NULL, device TEXT NOT NULL, action TEXT NOT NULL,
    boot TEXT NOT NULL, state TEXT NOT NULL, result TEXT, error TEXT
) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS goals_by_seq ON goals (seq);
DROP INDEX IF EXISTS open_goals; -- of older ledgers: it cost every change a page, for one look at the start
CREATE TABLE IF NOT EXISTS files (
    goal TEXT NOT NULL, seq INTEGER NOT NULL, name TEXT NOT NULL, path TEXT NOT NULL,
    sha256 TEXT NOT NULL, data BLOB NOT NULL, PRIMARY KEY (goal, name)
);
CREATE TABLE IF NOT EXISTS epochs (
    device TEXT PRIMARY KEY, epoch INTEGER NOT NULL, holder TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS chain (seq INTEGER PRIMARY KEY, hash BLOB NOT NULL);
"""
ROW = "SELECT id, seq, boot, state, result, error FROM goals "


class LedgerFault(Exception):
    """The ledger cannot be opened or written; the text says where and why."""


class LedgerInUse(LedgerFault):
    """Another server has it; perhaps one whose engine is gone, and which is just making its devices safe."""


class Ledger:
    """One SQLite file, owned by one server at a time, fully synced at every change.

    A sync may take as long as a disk likes, so an event loop calls its methods through `queued`.
    """

    on_real_disk: ClassVar[bool] = True

    def __init__(self, path: Path) -> None:
        self.path = path
        self._thread: ThreadQueue | None = None
        with _opening(path), ExitStack() as on_failure:
            self._disk = self._open()
            on_failure.callback(self._disk.close)
            self.id = self._fact("ledger", secrets.token_hex(6))
            # A boot contains its ledger's id, so that a client can see from a goal's boot alone
            # whether a server that does not know the goal ought to know it.
            self.boot = f"{self.id}.{secrets.token_hex(4)}"
            newest, self._newest_hash = self._newest_link()
            self._numbers, self._changed = itertools.count(newest + 1), 0
            self.mark = self._mark(newest, self._newest_hash)
            """The newest change on disk, as `ledger id:number:hash`."""
            on_disk = self.on_real_disk and str(path) != ":memory:"
            self._elsewhere = NewestMark(self.id, on_disk=on_disk)
            on_failure.callback(self._elsewhere.close)
            self._proves_from = int(self._fact("proves_from", "-1"))
            self._notice_put_back(newest)
            with_files = self._disk.execute("SELECT goal FROM files GROUP BY goal ORDER BY seq")
            self._with_files: list[str] = [row[0] for row in with_files]
            self.touched = self._close_open_goals()
            self._file = _file_of(path)
            on_failure.pop_all()

    def queued(self, work: Callable[[*Args], T], *args: *Args) -> asyncio.Future[T]:
        """Let a method of this ledger do its work after everything that was queued before it.

        It works in the ledger's own thread; one in memory has nothing to wait for, and works now.
        """
        if str(self.path) != ":memory:":
            if self._thread is None:
                self._thread = ThreadQueue("ledger")
            return self._thread.do(work, *args)
        done: asyncio.Future[T] = asyncio.get_running_loop().create_future()
        try:
            done.set_result(work(*args))
        except LedgerFault as fault:
            done.set_exception(fault)
        return done

    def taken_away(self) -> str:
        """What to say if its file is no longer where it was; empty as long as it is.

        What a server would write to a file that was removed is lost with the server.
        """
        if str(self.path) == ":memory:" or _file_of(self.path) == self._file:
            return ""
        what = "replaced" if self.path.exists() else "removed"
        return (
            f"the ledger {self.path} was {what} while this server had it, so it begins nothing more; "
            "end this server and start it again"
        )

    def _must_be_there(self) -> None:
        if said := self.taken_away():
            raise LedgerFault(said)

    def _open(self) -> sqlite3.Connection:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with ExitStack() as on_failure:
            disk = sqlite3.connect(
                self.path, isolation_level=None, timeout=LOCK_S, check_same_thread=False
            )
            on_failure.callback(disk.close)
            # It refuses a second server, and needs no shared memory.
            disk.execute("PRAGMA locking_mode = EXCLUSIVE")
            disk.execute("PRAGMA journal_mode = WAL")
            disk.execute("PRAGMA synchronous = FULL")
            disk.execute("PRAGMA fullfsync = ON")  # of macOS, as `system.files.sync_file`
            # An older file beside a newer write-ahead log has newest changes, and gaps before. A goal
            # whose id a disk has changed would count as one that never was: the index tells it.
            found = disk.execute("PRAGMA integrity_check(1)").fetchone()[0]
            if found != "ok":
                raise sqlite3.DatabaseError(found.replace("\n", " "))
            disk.executescript(TABLES)
            on_failure.pop_all()
        return disk

    def _fact(self, name: str, value: str) -> str:
        self._disk.execute("INSERT OR IGNORE INTO facts VALUES (?, ?)", (name, value))
        return self._disk.execute("SELECT value FROM facts WHERE name = ?", (name,)).fetchone()[0]

    def _newest_link(self) -> tuple[int, bytes]:
        """The number and hash of the newest change; a ledger without a chain gets one from here on."""
        newest = "SELECT seq, hash FROM chain ORDER BY seq DESC LIMIT 1"
        found = self._disk.execute(newest).fetchone()
        if found is None:
            seq = self._disk.execute("SELECT coalesce(max(seq), 0) FROM goals").fetchone()[0]
            rows = self._disk.execute("SELECT id, seq, state FROM goals ORDER BY seq").fetchall()
            held = self._disk.execute("SELECT * FROM epochs ORDER BY device").fetchall()
            found = seq, _hash(self.id.encode(), rows, held)
            self._disk.execute("INSERT INTO chain VALUES (?, ?)", found)
        return found

    def _notice_put_back(self, newest: int) -> None:
        """A ledger that lacks what it has written here itself: no mark from before proves anything.

        A client may have sent a goal after its newest mark that the goal's own server took, and this
        one never saw.
        """
        latest = self._elsewhere.read()
        if not latest or self.has(latest):
            return
        with self.writing():
            self._change("put back")
            self._disk.execute("UPDATE facts SET value = ? WHERE name = 'proves_from'", (newest,))
        self._proves_from = newest

    def _mark(self, seq: int, link: bytes) -> str:
        return f"{self.id}:{seq}:{link.hex()}"

    def has(self, mark: str) -> bool:
        """True if this ledger contains the change that a mark names, and has gone on from there."""
        ledger, _, rest = mark.partition(":")
        seq, _, link = rest.partition(":")
        rows = "SELECT hash FROM chain WHERE seq = ? AND seq > ?"
        known = self._disk.execute(rows, (seq, self._proves_from)).fetchone()
        return ledger == self.id and known is not None and known[0].hex() == link

    def _close_open_goals(self) -> set[str]:
        """Settle every goal that an earlier boot left open; returns the devices they were on."""
        rows = self._disk.execute(
            f"SELECT id, state, device FROM goals WHERE state IN {OPEN}"
        ).fetchall()
        with self.writing():
            for goal_id, state, _ in rows:
                error = NEVER_STARTED if state == "ACCEPTED" else INTERRUPTED
                self._end(goal_id, "ABORTED", None, error)
        return {device for _, state, device in rows if state != "ACCEPTED"}

    @contextmanager
    def writing(self) -> Iterator[None]:
        """One transaction, with one sync; raises LedgerFault where the disk does not take it."""
        before = self._newest_hash
        self._changed = 0
        try:
            self._disk.execute("BEGIN IMMEDIATE")
            yield
            self._disk.execute("COMMIT")
            if self._changed:
                self.mark = self._mark(self._changed, self._newest_hash)
                self._elsewhere.write(self.mark)
        except BaseException as fault:  # whatever it was, nothing of the row stays
            self._newest_hash = before
            if self._disk.in_transaction:
                self._disk.execute("ROLLBACK")
            if isinstance(fault, sqlite3.Error):
                raise LedgerFault(f"the ledger {self.path} cannot be written: {fault}") from fault
            raise

    def next_seq(self) -> int:
        """The number of the next change; grows for as long as the ledger exists, in any thread."""
        return next(self._numbers)

    def _change(self, *what: object) -> int:
        """Chain a change to the one before it, within a transaction; returns its number."""
        self._changed = seq = self.next_seq()
        # With the boot: what is done once more on an older copy is another change.
        self._newest_hash = _hash(self._newest_hash, self.boot, seq, *what)
        self._disk.execute("INSERT INTO chain VALUES (?, ?)", (seq, self._newest_hash))
        return seq

    def admit(self, goal: Goal, state: GoalState) -> int:
        """Write a new goal to disk, before anything else is done with it.

        Raises LedgerFault, and nothing has changed, for an id that is known already.
        """
        self._must_be_there()
        with self.writing():
            seq = self._change(goal.id, state)
            self._disk.execute(
                "INSERT INTO goals (id, seq, device, action, boot, state) VALUES (?, ?, ?, ?, ?, ?)",
                (goal.id, seq, goal.device, goal.action, self.boot, state),
            )
        return seq

    def begin(self, goal_id: str) -> None:
        """Record on disk that an accepted goal's driver is about to be called."""
        with self.writing():
            self._disk.execute(
                "UPDATE goals SET state = 'EXECUTING', seq = ? WHERE id = ?",
                (self._change(goal_id, "EXECUTING"), goal_id),
            )

    def bury(self, goal_id: str) -> None:
        """A tombstone for a goal that was cancelled before it arrived: it can never start."""
        with self.writing():
            self._disk.execute(
                "INSERT INTO goals VALUES (?, ?, '', '', ?, 'CANCELED', NULL, ?)",
                (
                    goal_id,
                    self._change(goal_id, "CANCELED"),
                    self.boot,
                    NEVER_STARTED.model_dump_json(),
                ),
            )

    def end(
        self,
        goal_id: str,
        state: GoalState,
        result: dict[str, Any] | None = None,
        error: GoalError | None = None,
        files: dict[str, FileContent] | None = None,
    ) -> int:
        """Write a goal's outcome to disk, before it is reported."""
        with self.writing():
            seq = self._end(goal_id, state, result, error)
            kept = self._keep_files(goal_id, seq, files) if files else self._with_files
        self._with_files = kept
        return seq

    def _end(
        self,
        goal_id: str,
        state: GoalState,
        result: dict[str, Any] | None,
        error: GoalError | None,
    ) -> int:
        result_text = None if result is None else json.dumps(result)
        error_text = None if error is None else error.model_dump_json()
        seq = self._change(goal_id, state, result_text, error_text)
        self._disk.execute(
            "UPDATE goals SET state = ?, seq = ?, boot = ?, result = ?, error = ? WHERE id = ?",
            (state, seq, self.boot, result_text, error_text, goal_id),
        )
        return seq

    def _keep_files(self, goal_id: str, seq: int, files: dict[str, FileContent]) -> list[str]:
        """Write them, delete those of the oldest goals; returns the goals that still have theirs."""
        self._disk.executemany(
            "INSERT OR REPLACE INTO files VALUES (?, ?, ?, ?, ?, ?)",
            [(goal_id, seq, n, f.path, f.sha256, f.data) for n, f in files.items()],
        )
        kept = [known for known in self._with_files if known != goal_id] + [goal_id]
        for old in kept[:-KEPT_FILES]:
            self._disk.execute("DELETE FROM files WHERE goal = ?", (old,))
        return kept[-KEPT_FILES:]

    def report(self, goal_id: str) -> GoalReport | None:
        """What is known about a goal; None if it was never seen."""
        row = self._disk.execute(ROW + "WHERE id = ?", (goal_id,)).fetchone()
        return None if row is None else self._report(row)

    def reports_since(self, seq: int, limit: int = 1000) -> Iterable[GoalReport]:
        """Goals that changed after change `seq`, oldest first, without their files."""
        rows = self._disk.execute(ROW + "WHERE seq > ? ORDER BY seq LIMIT ?", (seq, limit))
        return [self._report(row, files=False) for row in rows.fetchall()]

    def _report(self, row: tuple[Any, ...], *, files: bool = True) -> GoalReport:
        goal_id, seq, boot, state, result, error = row
        if not self._is_as_written(row):
            return GoalReport(id=goal_id, state="ABORTED", seq=seq, boot=boot, error=DAMAGED)
        return GoalReport(
            id=goal_id,
            state=state,
            seq=seq,
            boot=boot,
            result=None if result is None else json.loads(result),
            error=None if error is None else GoalError.model_validate_json(error),
            files=self._files(goal_id) if files and goal_id in self._with_files else {},
        )

    def _is_as_written(self, row: tuple[Any, ...]) -> bool:
        """Whether a goal's newest change is the one that was chained; older ledgers chained none."""
        goal_id, seq, boot, state, result, error = row
        links = "SELECT seq, hash FROM chain WHERE seq <= ? ORDER BY seq DESC LIMIT 2"
        newest, *before = self._disk.execute(links, (seq,)).fetchall() or [(None, b"")]
        if newest[0] != seq or not before:
            return True
        begun = state in OPEN or (state == "CANCELED" and error == NEVER_STARTED.model_dump_json())
        whats = [(goal_id, state, result, error), *([(goal_id, state)] if begun else [])]
        return any(_hash(before[0][1], boot, seq, *what) == newest[1] for what in whats)

    def _files(self, goal_id: str) -> dict[str, FileContent]:
        rows = self._disk.execute(
            "SELECT name, path, sha256, data FROM files WHERE goal = ?", (goal_id,)
        )
        return {name: FileContent(path=p, sha256=s, data=d) for name, p, s, d in rows}

    def epoch(self, device: str) -> int:
        """The latest epoch of a device; 0 before its first lease."""
        row = self._disk.execute("SELECT epoch FROM epochs WHERE device = ?", (device,)).fetchone()
        return 0 if row is None else row[0]

    def lease(self, device: str, holder: str) -> int:
        """A new epoch for a new lease; on disk before it is sent to the holder."""
        self._must_be_there()
        epoch = self.epoch(device) + 1
        with self.writing():
            self._change(device, epoch, holder)
            self._disk.execute(
                "INSERT OR REPLACE INTO epochs VALUES (?, ?, ?)", (device, epoch, holder)
            )
        return epoch

    def skip_epoch(self, device: str) -> None:
        """Skip a number, so that the next holder sees that another client intervened."""
        with self.writing():
            self._change(device, "skip")
            self._disk.execute("UPDATE epochs SET epoch = epoch + 1 WHERE device = ?", (device,))

    def unlease(self, device: str) -> None:
        """Record that the device has no holder and is in order."""
        with self.writing():
            self._disk.execute("UPDATE epochs SET holder = '' WHERE device = ?", (device,))

    def abandoned(self) -> set[str]:
        """Devices whose lease had neither been released nor lapsed when the last boot ended."""
        return {
            row[0] for row in self._disk.execute("SELECT device FROM epochs WHERE holder != ''")
        }

    def close(self) -> None:
        """Leave the file complete and unlocked for the next server; what is queued is written."""
        if self._thread is not None:
            self._thread.close()
        self._disk.close()
        self._elsewhere.close()


def _file_of(path: Path) -> tuple[int, int] | None:
    """Which file is there; None for none, or one that cannot be seen."""
    try:
        there = path.stat()
    except OSError:
        return None
    return there.st_dev, there.st_ino


@contextmanager
def _opening(path: Path) -> Iterator[None]:
    """What keeps a ledger from being opened, as a LedgerFault."""
    try:
        yield
    except (OSError, sqlite3.Error) as fault:
        if isinstance(fault, sqlite3.OperationalError) and "locked" in str(fault):
            raise LedgerInUse(
                f"another device server is using {path}; stop it, or give this one another folder"
            ) from fault
        if type(fault) is sqlite3.DatabaseError:
            raise LedgerFault(
                f"the ledger {path} is damaged: {fault}; move it away with its -wal and start "
                f"again: runs that have used it notice, and ask what happened"
            ) from fault
        closed = [
            part for part in (path.parent, path, path.with_name(f"{path.name}-wal"))
            if part.exists() and not os.access(part, os.R_OK | os.W_OK)
        ]  # fmt: skip
        why = f"{closed[0]} may not be written by this user" if closed else fault
        raise LedgerFault(f"the ledger {path} cannot be opened: {why}") from fault


def _hash(previous: bytes, *what: object) -> bytes:
    return blake2b(previous + repr(what).encode(errors="surrogatepass"), digest_size=16).digest()


INTERRUPTED = GoalError(
    name="INTERRUPTED",
    message="the device server ended during the action; its outcome is unknown",
    happened="unknown",
)
DAMAGED = GoalError(
    name="INTERRUPTED",
    message="the disk has changed what the ledger says of this action; its outcome is unknown",
    happened="unknown",
)
NEVER_STARTED = GoalError(
    name="NEVER_STARTED",
    message="the action ended before its driver was called",
    happened="no",
)
