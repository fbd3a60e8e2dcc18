import json

import pytest

from labrun.reduction.batch.gather import default_out, gather, is_reduced, root_of
from labrun.reduction.batch.summary import MADE_BY, NAME

ROWS = "200.0,5\n200.1,6\n"


def put(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(ROWS)


def names(found):
    return [source.name for source in found.spectra]


def test_a_folder_gives_its_spectra_and_those_below_in_natural_order(tmp_path):
    put(tmp_path, "s_10.csv", "s_9.csv", "deep/er/s_1.csv", "photo.jpg")
    found = gather([tmp_path], tmp_path / "out")

    assert names(found) == ["deep/er/s_1.csv", "s_9.csv", "s_10.csv"]
    assert [name for name, _ in found.left_aside] == ["photo.jpg"]


def test_a_file_that_was_named_is_taken_whatever_it_looks_like(tmp_path):
    (tmp_path / "notes.md").write_text("no spectrum")

    assert names(gather([tmp_path / "notes.md"], tmp_path / "out")) == ["notes.md"]


def test_files_and_folders_share_names_from_their_common_folder_and_come_once(tmp_path):
    put(tmp_path, "a/s.csv", "b/s.csv")
    found = gather([tmp_path / "a", tmp_path / "a" / "s.csv", tmp_path / "b"], tmp_path / "out")

    assert root_of([tmp_path / "a", tmp_path / "b"]) == tmp_path
    assert names(found) == ["a/s.csv", "b/s.csv"]


def test_of_a_run_only_what_its_devices_delivered(tmp_path):
    put(tmp_path, "spectra/core_0_0.csv", "servers/log.csv", "data.csv", "used/table.csv")
    (tmp_path / "journal.jsonl").write_text("{}\n")

    assert names(gather([tmp_path], tmp_path / "reduced")) == ["spectra/core_0_0.csv"]
    assert default_out([tmp_path]) == tmp_path / "reduced"


def test_of_a_run_that_names_its_folder_otherwise_all_but_working_state(tmp_path):
    put(tmp_path, "shots/1.csv", "servers/log.csv", "used/table.csv", "contracts/x.csv")
    (tmp_path / "run.json").write_text("{}\n")

    assert names(gather([tmp_path], tmp_path / "reduced")) == ["shots/1.csv"]


def test_tables_go_beside_a_folder_and_beside_a_file(tmp_path):
    put(tmp_path, "a/s.csv")

    assert default_out([tmp_path / "a"]) == tmp_path / "reduced"
    assert default_out([tmp_path / "a" / "s.csv"]) == tmp_path / "a" / "reduced"
    assert default_out([tmp_path / "a", tmp_path / "b"]) == tmp_path / "reduced"


def test_tables_of_earlier_reductions_are_no_spectra(tmp_path):
    put(tmp_path, "s.csv", "old/peaks.csv", "out/peaks.csv", "out/s.csv")
    (tmp_path / "old" / NAME).write_text(json.dumps({"made_by": MADE_BY}))

    assert is_reduced(tmp_path / "old")
    assert names(gather([tmp_path], tmp_path / "out")) == ["s.csv"]


def test_spectra_may_be_reduced_into_their_own_folder(tmp_path):
    put(tmp_path, "s.csv", "peaks.csv")
    (tmp_path / NAME).write_text(json.dumps({"made_by": MADE_BY}))

    assert names(gather([tmp_path], tmp_path)) == ["s.csv"]


def test_a_summary_of_somebody_else_makes_no_reduction(tmp_path):
    (tmp_path / NAME).write_text('{"made_by": "hand"}')

    assert not is_reduced(tmp_path)
    assert not is_reduced(tmp_path / "missing")


def test_a_folder_whose_links_go_round_is_walked_once(tmp_path):
    put(tmp_path, "a/s.csv")
    try:
        (tmp_path / "a" / "back").symlink_to(tmp_path, target_is_directory=True)
    except OSError:
        pytest.skip("this system makes no links for everybody")

    assert names(gather([tmp_path], tmp_path / "out")) == ["a/s.csv"]
