"""Journals of every version so far are resumed, and nothing that was done in them is done again."""

import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from labrun.engine.journal.course import split_goal_id
from labrun.engine.journal.journal import read_records

GOLDEN = sorted(
    path.parent for path in (Path(__file__).parent / "golden").glob("*/*/journal.jsonl")
)


def shots_of(folder):
    log = folder / "servers" / "world" / "truth" / "libs.jsonl"
    return [json.loads(line)["goal"] for line in log.read_text().splitlines()]


@pytest.mark.parametrize("golden", GOLDEN, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_a_golden_journal_is_resumed_to_its_end(tmp_path, golden):
    first = next(read_records(golden / "journal.jsonl"))
    folder = tmp_path / first.run
    shutil.copytree(golden, folder)
    written = (golden / "journal.jsonl").read_bytes()
    whole = written[: written.rfind(b"\n") + 1]
    before = shots_of(folder)

    ended = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "resume", str(folder), "--yes"],
        capture_output=True, text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},  # where no earlier resume of it is remembered
    )  # fmt: skip
    records = list(read_records(folder / "journal.jsonl"))
    shots = shots_of(folder)
    once = {r.id for r in records if r.kind == "goal" and r.effect == "once"}

    successes = [
        split_goal_id(r.id)[0]
        for r in records
        if r.kind == "ended" and r.id in once and r.state == "SUCCEEDED"
    ]

    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert (folder / "journal.jsonl").read_bytes().startswith(whole)
    assert shots[: len(before)] == before
    assert max(Counter(shots).values()) == 1
    assert set(shots) <= once
    assert max(Counter(successes).values()) == 1
    rows = (folder / "data.csv").read_text().splitlines()[1:]
    assert len(rows) == 9
    assert records[-1].outputs == {"points": 3}


def test_there_is_a_golden_journal_of_this_format():
    assert GOLDEN
