"""Tables of a run."""

from labrun.web.results.tables import table_names


def test_what_was_measured_comes_before_the_tables_of_loops_within(tmp_path):
    for name in ("data-scan-1-then-check.csv", "data.csv"):
        (tmp_path / name).write_text("key,fate\n")

    assert table_names(tmp_path) == ["data.csv", "data-scan-1-then-check.csv"]
