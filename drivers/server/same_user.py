"""Whether the other end of a connection is a program of this server's own user, as the kernel says.

Such a program could read the file with the token as well, so asking it for the token would keep
nobody out. Linux tells, in `/proc/net/tcp`; where nothing is told, the token is asked for.
"""

import contextlib
import os
import struct
from collections.abc import Iterator
from ipaddress import ip_address
from pathlib import Path

TABLES = {4: Path("/proc/net/tcp"), 6: Path("/proc/net/tcp6")}
ESTABLISHED, LISTENING = "01", "0A"

Address = tuple[str, int]


def is_told(listening: Address) -> bool:
    """Whether the kernel tells us whose connections there are: it then knows our own port as ours."""
    return any(user == _own() for user in _users(listening, None))


def is_own(peer: Address, here: Address) -> bool:
    """Whether the program at `peer`, connected to us at `here`, is one of our own user."""
    return any(user == _own() for user in _users(peer, here))


def _own() -> int:
    return os.getuid() if hasattr(os, "getuid") else -1


def _users(one: Address, other: Address | None) -> Iterator[int]:
    """The users of the sockets at `one` that are connected to `other`, or listen if there is none.

    Of a socket that its program has closed the kernel says user 0, whoever that was: it counts for nobody.
    """
    with contextlib.suppress(OSError, ValueError):  # no such table, or an address that is none
        version = ip_address(one[0]).version
        nobody = ("0.0.0.0" if version == 4 else "::", 0)
        state = LISTENING if other is None else ESTABLISHED
        wanted = [_in_table(one), _in_table(other or nobody), state]
        for line in TABLES[version].read_text(encoding="ascii").splitlines()[1:]:
            columns = line.split()
            if columns[1:4] == wanted:
                yield int(columns[7])


def _in_table(address: Address) -> str:
    packed = ip_address(address[0]).packed
    words = struct.unpack(f"={len(packed) // 4}I", packed)
    return "".join(f"{word:08X}" for word in words) + f":{address[1]:04X}"
