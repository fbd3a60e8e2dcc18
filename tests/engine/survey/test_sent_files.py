"""Files that lie beside a protocol and go to devices are kept with its run."""

import pytest

from labrun.engine.check import check_file
from labrun.engine.run.copies import keep_used
from labrun.engine.run.files import read_content, write_content
from labrun.engine.run.names import FileFault
from labrun.engine.survey.sent_files import sent_files
from labrun.schemas.messages import FileContent

PROTOCOL = """labrun: 1
name: t
params: {{with_what: {{type: string, default: bench.calibration}}}}
devices: {{libs: libs_analyzer@1, reduce: spectrum_reducer@1}}
steps:
  - {{do: libs.export, with: {{shot: a, file: spectra/a.csv}}}}
  - do: reduce.reduce
    with: {{spectrum: spectra/a.csv, calibration: "{written}"}}
"""


@pytest.fixture
def bench(tmp_path):
    """Surveys a protocol beside which a calibration lies, and an old file of the run's own name."""
    own = tmp_path / "own"
    (own / "spectra").mkdir(parents=True)
    (own / "bench.calibration").write_text("the one")
    (own / "spectra" / "a.csv").write_text("of another day")
    (tmp_path / "secret").write_text("not for a run")

    def surveyed(written):
        (own / "protocol.yaml").write_text(PROTOCOL.format(written=written))
        checked = check_file(own / "protocol.yaml", params={}, needed=True)

        assert checked.survey is not None
        return checked.survey

    return surveyed


@pytest.mark.parametrize("written", ["bench.calibration", "${{ params.with_what }}"])
def test_what_is_sent_is_copied_and_stays_what_it_was(tmp_path, bench, written):
    run = tmp_path / "run"
    run.mkdir()
    keep_used(run, "protocol.yaml", bench(written))
    (tmp_path / "own" / "bench.calibration").write_text("another one")

    assert read_content(run, "bench.calibration").data == b"the one"
    with pytest.raises(FileFault, match=r"spectra/a\.csv is not in the run's folder"):
        read_content(run, "spectra/a.csv")
    write_content(run, FileContent(path="bench.calibration", sha256=SHA_OF_X, data=b"x"))
    assert read_content(run, "bench.calibration").data == b"x"


SHA_OF_X = "2d711642b726b04401627ca9fbac32f5c8530fb1903cc4db02258717921a4881"


@pytest.mark.parametrize("written", ["../secret", "missing.calibration", "${{ steps }}"])
def test_nothing_else_is(bench, written):
    assert sent_files(bench(written)) == {}
