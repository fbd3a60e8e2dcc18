"""Reports that cannot be made: a line each, and the run's end all the same."""

import errno
from types import SimpleNamespace

from labrun.engine.runner import reports


def test_a_folder_that_cannot_be_written_is_a_line_and_no_traceback(tmp_path, monkeypatch, caplog):
    def refused(folder):
        raise OSError(errno.EROFS, "Read-only file system", str(folder / ".report.part"))

    point = SimpleNamespace(name="page", load=lambda: refused)
    monkeypatch.setattr(reports, "entry_points", lambda group: [point])

    assert reports.make_reports(tmp_path) == (
        [],
        [f"report 'page' was not made: {tmp_path}: Read-only file system"],
    )
    assert caplog.records == []
