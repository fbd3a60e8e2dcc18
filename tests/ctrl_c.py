"""What a test needs that sends Ctrl-C to one process: Windows sends it to all of a console."""

import sys

import pytest

TO_ONE = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows sends Ctrl-C to a whole console"
)
