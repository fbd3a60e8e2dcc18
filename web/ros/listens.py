"""Ports of this machine: is one in use, and which is free?"""

import socket


def listens(port: int) -> bool:
    """Whether something answers at a port of this machine."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def free_port(taken: set[int]) -> int:
    """A port that nobody uses now and that is not taken."""
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        if port not in taken:
            return port
