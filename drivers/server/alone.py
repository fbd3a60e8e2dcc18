"""One instrument has one device server at a time: two would let goals begin, unknown to each other.

A serial port the system keeps to one program; a program that is worked over a network, or by its
window, it does not. So the server locks a file, which the system frees when the process dies.
"""

import os
import tempfile
from contextlib import ExitStack
from hashlib import blake2b
from pathlib import Path

from ...system.files import lock_file


def alone_with(what: str) -> ExitStack:
    """Have an instrument until the stack is closed; raises OSError if another server has it."""
    key = blake2b(what.encode(), digest_size=8).hexdigest()
    path = Path(tempfile.gettempdir()) / f"labrun_alone_{key}.lock"
    with ExitStack() as having:
        file = having.enter_context(path.open("a+", encoding="utf-8"))
        try:
            lock_file(file)
        except OSError:
            file.seek(0)
            raise OSError(
                f"{what} has a device server already (process {file.read() or 'unknown'}): wait until "
                f"the run or call that started that has ended, or end it"
            ) from None
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        return having.pop_all()
