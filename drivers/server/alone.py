"""One instrument has one device server at a time: two would let goals begin, unknown to each other.

A serial port the system keeps to one program; a program that is worked over a network, or by its
window, it does not. So the server locks a file, which the system frees when the process dies.
"""

import os
from contextlib import ExitStack
from hashlib import blake2b

from ...system.files import lock_file, lock_of_this_computer
from ...system.process import alive


def alone_with(what: str) -> ExitStack:
    """Have an instrument until the stack is closed; raises OSError if another server has it."""
    key = blake2b(what.encode(), digest_size=8).hexdigest()
    with ExitStack() as having:
        file = having.enter_context(lock_of_this_computer(f"alone_{key}"))
        try:
            lock_file(file)
        except OSError:
            file.seek(0)
            said = file.read()  # of one that another user's server has locked, an older one
            holder = said if said.isdigit() and alive(int(said)) else "unknown"
            raise OSError(
                f"{what} has a device server already (process {holder}): wait until "
                f"the run, call or `labrun serve` that started that has ended, or end it"
            ) from None
        if file.writable():
            file.seek(0)
            file.truncate()
            file.write(str(os.getpid()))
            file.flush()
        return having.pop_all()
