"""The journal: records chained by hashes, whole or cut, and honest about a full disk."""

import errno
import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.engine.journal import journal as journal_module
from labrun.engine.journal.journal import (
    DiskFull,
    Journal,
    JournalFault,
    chain,
    read_records,
    reopen,
)
from labrun.schemas import journal as j


def written(path, *records):
    journal = Journal(path)
    for record in records:
        journal.append(record)
    journal.close()
    return path


def some(count):
    return [j.StepEnded(path=f"main/{n}", fate="succeeded", message=f"é {n}") for n in range(count)]


def test_records_come_back_in_order_and_numbered(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(3))

    assert [(r.n, r.path) for r in read_records(path)] == [
        (1, "main/0"),
        (2, "main/1"),
        (3, "main/2"),
    ]


def test_a_torn_last_record_is_cut_and_said(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(3))
    path.write_bytes(path.read_bytes()[:-7])

    journal, records, torn = reopen(path)
    journal.append(j.StepEnded(path="main/9", fate="failed"))
    journal.close()

    assert [r.n for r in records] == [1, 2, 3]
    assert torn > 0
    assert [r.path for r in read_records(path)] == ["main/0", "main/1", "main/9"]


def test_a_journal_that_an_older_copy_has_replaced_says_so(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(2))
    older = path.read_bytes()
    journal, _, _ = reopen(path)
    found = [journal.put_back]
    journal.append(j.StepEnded(path="main/2", fate="succeeded"))
    journal.close()
    path.write_bytes(older)

    for number in (3, 4):
        journal, _, _ = reopen(path)
        found.append(journal.put_back)
        journal.append(j.StepEnded(path=f"main/{number}", fate="succeeded"))
        journal.close()

    assert found == [False, True, False]


def test_what_follows_a_sector_that_a_power_cut_has_left_empty_was_never_durable(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(4))
    data = path.read_bytes()
    third = data.index(b'{"n":3')
    path.write_bytes(data[: third + 5] + bytes(20) + data[third + 25 :])

    journal, records, torn = reopen(path)
    journal.close()

    assert [r.n for r in records] == [1, 2]
    assert (torn, path.read_bytes()) == (len(data) - third, data[:third])


def test_a_changed_record_breaks_the_chain_and_is_named(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(4))
    path.write_bytes(path.read_bytes().replace(b"main/1", b"main/7"))

    with pytest.raises(JournalFault, match="chain breaks at record 2"):
        list(read_records(path))


def test_a_write_that_failed_once_leaves_a_chain_that_is_whole(tmp_path, monkeypatch):
    journal = Journal(tmp_path / "journal.jsonl")
    write, failures = os.write, [OSError(errno.EIO, "Input/output error")]

    def failing(file, data):
        if failures:
            raise failures.pop()
        return write(file, data)

    monkeypatch.setattr(journal_module.os, "write", failing)
    for record in some(2):
        journal.append(record)
    with pytest.raises(JournalFault, match="Input/output error"):
        journal.flush()
    journal.append(j.Finished(fate="failed"))
    journal.close()

    assert [r.n for r in read_records(tmp_path / "journal.jsonl")] == [1, 2, 3]


def test_bytes_that_are_no_text_break_the_chain_like_any_other_change(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(2))
    path.write_bytes(path.read_bytes().replace(b"main", b"\xff\xfe\xfd\xfc"))

    with pytest.raises(JournalFault, match="the chain breaks at record"):
        list(read_records(path))


def test_a_record_taken_out_breaks_the_chain(tmp_path):
    path = written(tmp_path / "journal.jsonl", *some(4))
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([lines[0], *lines[2:]]))

    with pytest.raises(JournalFault, match="record 2"):
        list(read_records(path))


def test_a_journal_of_a_newer_format_is_refused_with_a_sentence(tmp_path):
    started = j.Started(run="r", protocol="p", labrun="9", python="3", format=j.FORMAT + 1)
    path = written(tmp_path / "journal.jsonl", started)

    with pytest.raises(JournalFault, match="newer one"):
        list(read_records(path))


@pytest.mark.parametrize(
    "newer", [{"kind": "phase", "phase": "main", "colour": "red"}, {"kind": "painted"}]
)
def test_a_run_that_a_newer_labrun_has_gone_on_with_says_so(tmp_path, newer):
    path = written(tmp_path / "journal.jsonl", *some(1))
    body = json.dumps({"n": 2, "at": "2026-11-24T08:00:00Z", **newer})[:-1]
    previous = json.loads(path.read_text())["hash"]
    with path.open("a", newline="\n") as file:
        file.write(f'{body},"hash":"{chain(previous, body)}"}}\n')

    with pytest.raises(
        JournalFault, match=r"record 2 .* A newer labrun .*; resume it with that one"
    ):
        list(read_records(path))


def test_a_full_disk_is_told_and_the_record_is_in_the_reserve(tmp_path, monkeypatch):
    path = tmp_path / "journal.jsonl"
    journal = Journal(path)
    journal.append(some(1)[0])
    journal.flush()
    real_write = os.write
    reserve = tmp_path / "journal.reserve"

    def full_while_the_reserve_stands(descriptor, data):
        if reserve.exists():
            raise OSError(errno.ENOSPC, "No space left on device")
        return real_write(descriptor, data)

    monkeypatch.setattr(journal_module.os, "write", full_while_the_reserve_stands)
    journal.append(some(2)[1])
    with pytest.raises(DiskFull, match="no space left"):
        journal.flush()
    journal.close()

    assert [r.path for r in read_records(path)] == ["main/0", "main/1"]


@given(
    rows=st.lists(
        st.dictionaries(st.text(max_size=5), st.one_of(st.none(), st.integers(), st.text()))
    ),
    cut=st.integers(min_value=0, max_value=400),
)
def test_whatever_is_cut_off_the_end_the_records_before_it_are_read(tmp_path_factory, rows, cut):
    path = tmp_path_factory.mktemp("j") / "journal.jsonl"
    records = [
        j.IterationEnded(loop="main/l", index=i, key=str(i), fate="succeeded", row=row)
        for i, row in enumerate(rows)
    ]
    data = written(path, *records).read_bytes()
    path.write_bytes(data[: max(0, len(data) - cut)])

    whole = list(read_records(path))

    assert [r.row for r in whole] == [r.row for r in records[: len(whole)]]
    assert len(whole) == data[: max(0, len(data) - cut)].count(b"\n")
