"""A run in brief beside its journal, and its four numbers, the same wherever they are told."""

import json

from labrun.engine.commands.runs import row, runs
from labrun.engine.index.entry import entry_of
from labrun.engine.journal import journal as journal_module
from labrun.engine.run.summary import FILE, kept_summary, summary_of
from labrun.web.runs.quick import quick_summary

SCAN = """
steps:
  - id: scan
    foreach: {i: "${{ range(7) }}"}
    keep_going: {max_failed: MOST}
    steps: [{do: a.act, with: {name: "x${{ i }}", script: "${{ 'Broken' if i > 3 else 'ok' }}"}}]
    collect: {i: "${{ i }}"}
"""


def numbers(told):
    return told["plan"], told["measured"], told["failed"], told["left"]


def test_a_run_that_fails_keeps_its_size(own_device):
    told = []
    ran = own_device().run(SCAN.replace("MOST", "2"), watch=lambda e: told.append(e))

    listed, quick = row(entry_of(ran.folder), ran.folder.parent), quick_summary(ran.folder)
    assert numbers(listed) == numbers(ran.finished.points.model_dump()) == (7, 4, 2, 1)
    assert (quick.total, quick.measured, quick.failed, quick.left) == (7, 4, 2, 1)
    assert told[-1].data["points"] == listed["points"] == "4 of 7 measured, 2 failed, 1 left"
    assert "4 of 7 measured, 2 failed, 1 left" in (ran.folder / "report.html").read_text()


def test_success_with_holes_is_its_own_word(own_device, capsys):
    ran = own_device().run(SCAN.replace("MOST", "3"))

    quick = quick_summary(ran.folder)
    assert ran.status == 0
    assert (
        row(entry_of(ran.folder), ran.folder.parent)["word"]
        == quick.word
        == "succeeded with 3 holes"
    )
    assert (quick.fate, row(entry_of(ran.folder), ran.folder.parent)["fate"]) == (
        "succeeded",
        "succeeded",
    )
    assert "The run succeeded with 3 holes." in (ran.folder / "report.html").read_text()
    capsys.readouterr()
    runs(ran.folder.parent, find="", value="", json=False)
    assert "succeeded with 3 holes  4 of 7 measured, 3 failed\n" in capsys.readouterr().out


def test_the_list_of_runs_reads_no_journal(own_device, monkeypatch):
    ran = own_device().run(SCAN.replace("MOST", "3"))
    monkeypatch.setattr(journal_module, "RECORD", None)  # whoever parses a record fails

    assert row(entry_of(ran.folder), ran.folder.parent)["measured"] == 4


def test_a_summary_that_is_not_the_journals_counts_for_nothing(own_device):
    ran = own_device().run(SCAN.replace("MOST", "3"))
    kept = ran.folder / FILE
    kept.write_text(json.dumps({**json.loads(kept.read_text()), "last": "0" * 32, "holes": 0}))

    assert kept_summary(ran.folder) is None
    assert summary_of(ran.folder).holes == 3
    assert kept_summary(ran.folder).holes == 3


def test_a_run_that_was_killed_is_read_once(own_device):
    device = own_device()
    ran = device.run(SCAN.replace("MOST", "3"))
    device.kill_after('"kind":"iteration","loop":"main/scan","index":2')

    first = row(entry_of(ran.folder), ran.folder.parent)
    assert (first["fate"], numbers(first)) == ("interrupted", (7, 3, 0, 4))
    assert kept_summary(ran.folder).fate == "interrupted"
    assert quick_summary(ran.folder) is None  # the page opens it, to say more


def test_a_torn_journal_has_no_summary_beside_it(own_device):
    ran = own_device().run(SCAN.replace("MOST", "3"))
    with (ran.folder / "journal.jsonl").open("a", newline="\n") as file:
        file.write('{"n":')

    assert row(entry_of(ran.folder), ran.folder.parent)["measured"] == 4
    assert kept_summary(ran.folder) is None
