"""Who may come in at a port of this machine.

A page of any site can make a browser connect to this machine, even under a name of its own that it
made resolve here (DNS rebinding). So at a port that only this machine can reach, the Host must be a
name of this machine; and a page may only use the server that it came from. Programs send no Origin.
A port that others can reach is open to whoever has the token, by whatever name they know it.
"""

import ipaddress
from urllib.parse import SplitResult, urlsplit


def why_not(listens_on: str, host: str, origin: str | None) -> str | None:
    """Why a request with this Host and Origin may not come in; None if it may."""
    if is_loopback(listens_on) and not is_loopback(split(f"//{host}").hostname or ""):
        return f"this server is not {host[:100]!r}"
    if origin is not None and split(origin).netloc.lower() != host.lower():
        return "pages of other sites may not use this server"
    return None


def is_loopback(host: str) -> bool:
    """True for an address that only this machine can reach."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def split(address: str) -> SplitResult:
    """The parts of an address; empty for one that cannot be parsed."""
    try:
        return urlsplit(address)
    except ValueError:
        return urlsplit("")
