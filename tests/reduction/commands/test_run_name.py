"""A run is named to `labrun reduce` and `map` as to every other command."""

import os
from pathlib import Path

import pytest

from labrun.reduction.commands.run_name import or_run


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("7f3a", "runs/2026-11-21_map_7f3a"),
        ("2026-11-20_map_11aa", "runs/2026-11-20_map_11aa"),
        ("last", "runs/2026-11-20_map_11aa"),  # the one that was written last
        ("spectra", "spectra"),  # what lies there goes first
        ("a", "a"),  # of several none
        ("none", "none"),
        ("elsewhere/7f3a", "elsewhere/7f3a"),
    ],
)
def test_a_run_is_found_by_its_name_where_nothing_else_is_called_so(
    tmp_path, monkeypatch, name, found
):
    monkeypatch.chdir(tmp_path)
    Path("spectra").mkdir()
    for at, run in enumerate(("2026-11-21_map_7f3a", "2026-11-20_map_11aa", "2026_spectra")):
        journal = Path("runs", run, "journal.jsonl")
        journal.parent.mkdir(parents=True)
        journal.touch()
        os.utime(journal, (at % 2, at % 2))

    assert or_run(Path(name)) == Path(found)
