import os
import subprocess
import sys

import pytest
from folders import many, shots, spectra, tables_of

from labrun.engine.cli import main
from labrun.reduction.lines.lines import use_lines

__all__ = ["many", "shots", "spectra", "tables_of"]


@pytest.fixture
def labrun(tmp_path, monkeypatch, capfd):
    """The command line in this process: another Python for every sentence costs a second of processor."""

    def call(*words):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["labrun", *map(str, words)])
        monkeypatch.setitem(os.environ, "COLUMNS", "200")
        with pytest.raises(SystemExit) as end:
            main()
        return subprocess.CompletedProcess(sys.argv, end.value.code, *capfd.readouterr())

    yield call
    use_lines(None)
