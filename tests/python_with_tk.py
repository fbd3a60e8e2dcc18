"""The Python that shows the tests' own Tk programs: the one that runs them may lack tkinter."""

import shutil
import subprocess
import sys
from functools import cache


@cache
def python_with_tk() -> str | None:
    """Any Python of this machine that imports tkinter; None where there is none."""
    pythons = [shutil.which(name) for name in (sys.executable, "/usr/bin/python3", "python3")]
    for python in filter(None, pythons):
        if not subprocess.run([python, "-c", "import tkinter"], capture_output=True).returncode:
            return python
    return None
