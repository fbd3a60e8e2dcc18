"""The ledger knows of every goal whether it began, was interrupted, or how it ended."""

import asyncio
import sqlite3
import tempfile
import time
from contextlib import closing
from hashlib import sha256

import pytest

from labrun.drivers.server.ledger import KEPT_FILES, Ledger, LedgerFault
from labrun.schemas.messages import FileContent, Goal, GoalError


@pytest.fixture
def path(tmp_path):
    return tmp_path / "server" / "ledger.sqlite"


def goal(goal_id):
    return Goal(id=goal_id, device="arm", boot="b", epoch=1, action="go")


def file(data):
    return FileContent(path="out.bin", sha256=sha256(data).hexdigest(), data=data)


def reopened(ledger):
    ledger.close()
    return Ledger(ledger.path)


def test_an_outcome_is_kept_over_a_restart_with_its_files(path):
    ledger = Ledger(path)
    ledger.admit(goal("g1"), "EXECUTING")
    ledger.end("g1", "SUCCEEDED", {"x": 1.5}, None, {"file": file(b"\x00\xff")})
    boot = ledger.boot
    ledger = reopened(ledger)
    report = ledger.report("g1")
    ledger.close()

    assert (report.state, report.result, report.boot) == ("SUCCEEDED", {"x": 1.5}, boot)
    assert report.files == {"file": file(b"\x00\xff")}


def test_an_error_is_kept_word_for_word(path):
    ledger = Ledger(path)
    ledger.admit(goal("g1"), "EXECUTING")
    error = GoalError(name="Jammed", message="the drawer is stuck", happened="no")
    ledger.end("g1", "ABORTED", error=error)
    report = ledger.report("g1")
    ledger.close()

    assert report.error == error


def test_what_was_under_way_is_interrupted_and_what_waited_never_started(path):
    ledger = Ledger(path)
    ledger.admit(goal("waited"), "ACCEPTED")
    ledger.admit(goal("ran"), "EXECUTING")
    ledger.admit(goal("began"), "ACCEPTED")
    ledger.begin("began")
    ledger.admit(goal("waited elsewhere").model_copy(update={"device": "lamp"}), "ACCEPTED")
    ledger = reopened(ledger)
    errors = {i: ledger.report(i).error for i in ("waited", "ran", "began")}
    touched = ledger.touched
    ledger.close()

    assert (errors["waited"].name, errors["waited"].happened) == ("NEVER_STARTED", "no")
    assert (errors["ran"].name, errors["ran"].happened) == ("INTERRUPTED", "unknown")
    assert errors["began"] == errors["ran"]
    assert touched == {"arm"}


def test_a_goal_that_was_never_seen_is_none(path):
    ledger = Ledger(path)
    report = ledger.report("g1")
    ledger.close()

    assert report is None


def test_the_ledgers_id_stays_and_the_boot_is_new_at_every_start(path, tmp_path):
    first = Ledger(path)
    ids, boots = [first.id], [first.boot]
    second = reopened(first)
    other = Ledger(tmp_path / "other.sqlite")
    ids += [second.id, other.id]
    boots += [second.boot, other.boot]
    second.close()
    other.close()

    assert ids[0] == ids[1] != ids[2]
    assert len(set(boots)) == 3
    assert all(boot.startswith(f"{i}.") for i, boot in zip(ids, boots, strict=True))


def test_epochs_grow_over_restarts(path):
    ledger = Ledger(path)
    first = ledger.lease("arm", "run-1")
    ledger = reopened(ledger)
    second = ledger.lease("arm", "run-2")
    held = ledger.abandoned()
    ledger.unlease("arm")
    free = ledger.abandoned()
    ledger.close()

    assert second == first + 1
    assert (held, free) == ({"arm"}, set())


def test_changes_are_numbered_on_over_restarts(path):
    ledger = Ledger(path)
    ledger.admit(goal("g1"), "EXECUTING")
    before = ledger.end("g1", "SUCCEEDED", {})
    ledger = reopened(ledger)
    after = ledger.admit(goal("g2"), "EXECUTING")
    since = [report.id for report in ledger.reports_since(before)]
    ledger.close()

    assert after == before + 1
    assert since == ["g2"]


def test_files_of_the_oldest_goals_make_room_and_their_results_stay(path):
    ledger = Ledger(path)
    for n in range(KEPT_FILES + 3):
        if n == KEPT_FILES // 2:
            ledger = reopened(ledger)
        ledger.admit(goal(f"g{n}"), "EXECUTING")
        ledger.end(f"g{n}", "SUCCEEDED", {"n": n}, None, {"file": file(b"%d" % n)})
    with_files = [n for n in range(KEPT_FILES + 3) if ledger.report(f"g{n}").files]
    oldest = ledger.report("g0").result
    on_disk = ledger._disk.execute("SELECT count(DISTINCT goal) FROM files").fetchone()[0]
    ledger.close()

    assert on_disk == KEPT_FILES
    assert with_files == list(range(3, KEPT_FILES + 3))
    assert oldest == {"n": 0}


def test_a_second_server_is_kept_out(path):
    ledger = Ledger(path)
    with pytest.raises(LedgerFault, match="another device server is using") as caught:
        Ledger(path)
    ledger.close()

    assert str(path) in str(caught.value)


@pytest.mark.posix("an open file can be taken away")
@pytest.mark.parametrize("what", ["removed", "replaced"])
def test_nothing_begins_on_a_ledger_whose_file_was_taken_away(path, what):
    with closing(Ledger(path)) as ledger:
        ledger.admit(goal("g1"), "EXECUTING")
        path.parent.rename(path.parent.with_name("old"))
        others = [Ledger(path)] if what == "replaced" else []
        for begun in (
            lambda: ledger.admit(goal("g2"), "EXECUTING"),
            lambda: ledger.lease("arm", "me"),
        ):
            with pytest.raises(LedgerFault, match=f"was {what} while this server had it"):
                begun()
        ledger.end("g1", "SUCCEEDED")
        for other in others:
            other.close()

        assert ledger.report("g1").state == "SUCCEEDED"


def test_a_place_that_cannot_be_written_is_not_told_as_another_server(path):
    path.mkdir(parents=True)

    with pytest.raises(LedgerFault, match="cannot be opened: unable to open") as caught:
        Ledger(path)
    assert type(caught.value) is LedgerFault  # a start is not tried again


def test_a_file_that_is_no_ledger_is_a_sentence(path):
    path.parent.mkdir()
    path.write_bytes(b"no database at all, and longer than a header of one hundred bytes" * 4)

    with pytest.raises(LedgerFault, match="is damaged: file is not a database; move it away"):
        Ledger(path)


def test_a_ledger_that_can_be_read_and_not_written_is_a_sentence(path, monkeypatch):
    Ledger(path).close()
    disk = sqlite3.connect(path, isolation_level=None)
    disk.execute("PRAGMA query_only = ON")  # as where its write-ahead log may not be written
    monkeypatch.setattr(sqlite3, "connect", lambda at, **more: disk)

    with pytest.raises(LedgerFault, match="cannot be opened: attempt to write a readonly database"):
        Ledger(path)


def test_an_older_file_beside_the_newest_write_ahead_log_is_no_ledger(path):
    ledger = Ledger(path)
    ledger._disk.execute("PRAGMA synchronous = OFF")
    older = b""
    for number in range(400):
        ledger.admit(goal(f"run/{number}/1"), "EXECUTING")
        if number in (200, 390):
            ledger._disk.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            older = older or path.read_bytes()
    mixed = path.parent / "mixed" / path.name
    mixed.parent.mkdir()
    mixed.write_bytes(older)
    log = mixed.with_name(f"{path.name}-wal")
    log.write_bytes(path.with_name(log.name).read_bytes())
    ledger.close()

    with pytest.raises(LedgerFault, match=r"is damaged: .*; move it away"):
        Ledger(mixed)


def test_a_letter_of_a_goal_that_a_disk_has_changed_is_damage_not_a_goal_that_never_was(path):
    with closing(Ledger(path)) as ledger:
        ledger.admit(goal("run/main/shoot/1"), "EXECUTING")
    data = path.read_bytes()
    path.write_bytes(data.replace(b"run/main/shoot/1", b"run/main/shoot/9", 1))

    with pytest.raises(LedgerFault, match="is damaged"):
        Ledger(path)


@pytest.mark.parametrize(
    ("written", "read"),
    [
        (b'{"x": 1.5}', b'{"x": 7.5}'), (b'{"x": 1.5}', b'{"x": 1.5]'),
        (b"SUCCEEDED", b"SUCCEEDEE"), (b"SUCCEEDED", b"CANCELED\x00"),
        (b"NEVER_STARTED", b"NEVER_STASTED"),
    ],
)  # fmt: skip
def test_an_outcome_that_a_disk_has_changed_is_unknown_and_never_another_one(path, written, read):
    with closing(Ledger(path)) as ledger:
        ledger.admit(goal("run/done/1"), "EXECUTING")
        ledger.end("run/done/1", "SUCCEEDED", {"x": 1.5})
        ledger.bury("run/not/1")
        ledger.admit(goal("run/next/1"), "EXECUTING")
    path.write_bytes(path.read_bytes().replace(written, read, 1))
    with closing(Ledger(path)) as ledger:
        told = {one.id: one for one in ledger.reports_since(0)}
    damaged = told.pop("run/not/1" if written == b"NEVER_STARTED" else "run/done/1")

    assert (damaged.state, damaged.result) == ("ABORTED", None)
    assert damaged.error.happened == "unknown"
    assert "the disk has changed what the ledger says" in damaged.error.message
    assert all("disk" not in getattr(one.error, "message", "") for one in told.values())


def test_a_full_disk_is_a_sentence_and_what_was_written_stays(path):
    ledger = Ledger(path)
    ledger.admit(goal("g1"), "EXECUTING")
    fill(ledger)
    with pytest.raises(LedgerFault, match="cannot be written: database or disk is full"):
        ledger.admit(Goal(**{**goal("x" * 900).model_dump(), "action": "y" * 9000}), "EXECUTING")
    report = ledger.report("g1")
    ledger.close()

    assert report.state == "EXECUTING"


def fill(ledger):
    pages = ledger._disk.execute("PRAGMA page_count").fetchone()[0]
    ledger._disk.execute(f"PRAGMA max_page_count = {pages}")


def test_the_files_of_a_goal_and_its_outcome_are_written_together_or_not_at_all(path):
    ledger = Ledger(path)
    ledger.admit(goal("g1"), "EXECUTING")
    fill(ledger)
    with pytest.raises(LedgerFault):
        ledger.end("g1", "SUCCEEDED", {}, None, {"file": file(b"x" * 100_000)})
    report = ledger.report("g1")
    ledger.close()

    assert (report.state, report.files) == ("EXECUTING", {})


def test_files_that_an_outcome_would_have_displaced_are_there_if_it_was_not_written(path):
    ledger = Ledger(path)
    for number in range(KEPT_FILES + 1):
        ledger.admit(goal(f"g{number}"), "EXECUTING")
    for number in range(KEPT_FILES):
        ledger.end(f"g{number}", "SUCCEEDED", {}, None, {"file": file(b"x")})

    def without_commit(action, what, *rest):
        refused = action == sqlite3.SQLITE_TRANSACTION and what == "COMMIT"
        return sqlite3.SQLITE_DENY if refused else sqlite3.SQLITE_OK

    ledger._disk.set_authorizer(without_commit)
    with pytest.raises(LedgerFault, match="not authorized"):
        ledger.end(f"g{KEPT_FILES}", "SUCCEEDED", {}, None, {"file": file(b"y")})
    ledger._disk.set_authorizer(None)
    oldest = ledger.report("g0")
    ledger.close()

    assert oldest.files == {"file": file(b"x")}


def test_every_change_is_synced(path):
    ledger = Ledger(path)
    modes = [
        ledger._disk.execute(f"PRAGMA {p}").fetchone()[0] for p in ("journal_mode", "synchronous")
    ]
    ledger.close()
    with sqlite3.connect(path) as disk:
        tables = {
            row[0] for row in disk.execute("SELECT name FROM sqlite_master WHERE type='table'")
        }
    disk.close()

    assert modes == ["wal", 2]
    assert {"goals", "files", "epochs", "facts"} <= tables


def test_an_older_copy_that_has_the_mark_which_a_client_knows_is_noticed_all_the_same(path):
    def opened(*ids):
        with closing(Ledger(path)) as ledger:
            for one in ids:
                ledger.admit(goal(one), "EXECUTING")
            return ledger.mark, [ledger.has(mark) for mark in marks]

    marks = []
    marks += [opened("g1")[0]]
    copy = path.read_bytes()
    marks += [opened("g2")[0]]  # taken, and its client died before it was told
    path.write_bytes(copy)
    newest, put_back = opened()
    marks += [newest]

    assert put_back == [False, False]
    assert opened("g3")[1] == opened()[1] == [False, False, True]  # after more changes, too


def test_a_ledger_has_every_mark_that_it_gave_over_restarts_too(path):
    ledger = Ledger(path)
    marks = [ledger.mark]
    for change in (
        lambda: ledger.lease("arm", "me"),
        lambda: ledger.admit(goal("g1"), "ACCEPTED"),
        lambda: ledger.begin("g1"),
        lambda: ledger.end("g1", "SUCCEEDED", {"x": 1}),
        lambda: ledger.bury("g2"),
        lambda: ledger.skip_epoch("arm"),
    ):
        change()
        marks.append(ledger.mark)
    ledger = reopened(ledger)
    known = [ledger.has(mark) for mark in marks]
    ledger.close()

    assert len(set(marks)) == 7
    assert all(known)


def test_an_older_copy_lacks_the_newer_marks_also_once_it_was_used_for_the_same_again(
    path, monkeypatch, tmp_path
):
    monkeypatch.setattr(
        tempfile, "tempdir", str(tmp_path / "none")
    )  # after a restart of the computer
    ledger = Ledger(path)
    ledger.lease("arm", "me")
    before = ledger.mark
    ledger.close()
    older = path.read_bytes()
    ledger = Ledger(path)
    ledger.admit(goal("g1"), "EXECUTING")
    after = ledger.mark
    ledger.close()
    path.write_bytes(older)
    ledger = Ledger(path)
    known = [ledger.has(before), ledger.has(after)]
    ledger.admit(goal("g1"), "EXECUTING")
    known.append(ledger.has(after))
    ledger.close()

    assert known == [True, False, False]


@pytest.mark.parametrize("mark", ["", "x", ":", "::", "a:1", "a:1:zz", "a:b:c", "a:9e9:"])
def test_what_is_no_mark_of_it_is_not_in_a_ledger(path, mark):
    ledger = Ledger(path)
    known = ledger.has(mark)
    ledger.close()

    assert not known


def test_a_change_that_the_disk_did_not_take_leaves_the_mark_as_it_was(path):
    ledger = Ledger(path)
    ledger.lease("arm", "me")
    mark = ledger.mark
    with pytest.raises(LedgerFault), ledger.writing():
        ledger._change("never")
        raise sqlite3.OperationalError("database or disk is full")
    unchanged = ledger.mark == mark
    ledger.lease("arm", "you")
    goes_on = ledger.has(mark) and ledger.has(ledger.mark)
    ledger.close()

    assert unchanged and goes_on


def test_a_ledger_from_before_marks_gets_one_that_says_what_is_in_it(path):
    ledger = Ledger(path)
    ledger.lease("arm", "me")
    ledger.admit(goal("g1"), "EXECUTING")
    ledger._disk.execute("DROP TABLE chain")
    ledger = reopened(ledger)
    mark = ledger.mark
    ledger = reopened(ledger)
    known = ledger.has(mark)
    ledger.close()

    assert known


def test_what_is_queued_is_done_in_its_order_however_long_each_takes(path):
    done = []

    def slowly(seconds):
        time.sleep(seconds)
        done.append(seconds)

    async def story():
        ledger = Ledger(path)
        await asyncio.gather(*(ledger.queued(slowly, seconds) for seconds in (0.2, 0.1, 0.0)))
        ledger.close()

    asyncio.run(story())

    assert done == [0.2, 0.1, 0.0]
