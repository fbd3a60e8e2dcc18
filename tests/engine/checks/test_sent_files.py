"""A name that an action reads is looked for where a run would find it."""

import pytest

from labrun.engine.check import check_file

PROTOCOL = """labrun: 1
name: t
params: {{a: {{type: string, default: one}}}}
devices: {{libs: libs_analyzer@1, reduce: spectrum_reducer@1}}
steps:
  - {{id: out, do: libs.export, with: {{shot: a, file: "{written}"}}}}
  - do: reduce.reduce
    with: {{spectrum: "{read}"}}
"""


@pytest.mark.parametrize(
    ("written", "read", "warned"),
    [
        ("spectra/a.csv", "spectra/a.csv", ""),
        ("spectra/a.csv", "beside.csv", ""),
        ("spectra/a.csv", "${{ steps.out.file }}", ""),
        ("spectra/${{ now() }}.csv", "spectra/b.csv", ""),
        ("${{ now() }}.csv", "b.csv", ""),
        ("spectra/a.csv", "spectra/b.csv", "did you mean spectra/a.csv?"),
        ("spectra/${{ now() }}.csv", "besides.csv", "did you mean beside.csv?"),
        ("spectra/a.csv", "${{ params.a }}.csv", "no step writes it, and there is no file one.csv"),
    ],
)
def test_only_a_name_that_nothing_can_have_is_warned_of(tmp_path, written, read, warned):
    (tmp_path / "beside.csv").write_text("1,2\n")
    (tmp_path / "t.yaml").write_text(PROTOCOL.format(written=written, read=read))
    problems = [one for one in check_file(tmp_path / "t.yaml").problems if one.code == "W426"]

    assert bool(problems) == bool(warned)
    for one in problems:
        assert warned in f"{one.message}. {one.hint}"
