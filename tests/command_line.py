"""The command line in this process: another Python for every sentence costs a second of a processor."""

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.engine.cli import main


def labrun(folder: Path, *words: object, stdin: bytes = b"") -> subprocess.CompletedProcess[str]:
    """What `labrun WORDS` in a folder prints and ends with."""
    out, err = io.BytesIO(), io.BytesIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.chdir(folder):
        patch.setattr(sys, "argv", ["labrun", *map(str, words)])
        patch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin), "utf-8"))
        patch.setattr(sys, "stdout", io.TextIOWrapper(out, "utf-8", write_through=True))
        patch.setattr(sys, "stderr", io.TextIOWrapper(err, "utf-8", write_through=True))
        patch.setattr(os, "_exit", sys.exit)
        patch.setattr("gc.freeze", lambda: None)
        with pytest.raises(SystemExit) as end:
            main()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        told = out.getvalue().decode(), err.getvalue().decode()
    return subprocess.CompletedProcess(sys.argv, end.value.code or 0, *told)
