"""The Python face: `labrun.run`, `check`, `rehearse`, `load`, `runs`.

It has no way of its own to do anything: it calls what the commands call.
"""

from contextlib import suppress

with suppress(ImportError):
    import numpy  # noqa: F401 - before pint, so that quantities and arrays of a notebook know each other
