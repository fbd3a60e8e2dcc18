"""Who may come in at a port of this machine.

A page of any site can make a browser connect to this machine, even under a name of its own that it
made resolve here (DNS rebinding). So at a port that only this machine can reach, the Host must be a
name of this machine; and a page may only use the server that it came from. Programs send no Origin.
A port that others can reach is open to whoever has the token, by whatever name they know it.
"""

import asyncio
import hmac
import ipaddress
import socket
from urllib.parse import SplitResult, urlsplit

GUESS_S = 0.5
"""How long a wrong token holds up the next."""
GUESSES_WAITING = 4


class Brake:
    """The token of a port: those that are given are looked at one by one, a moment apart after a wrong one.

    Those in excess are not looked at at all. Without a token everybody may come in.
    """

    def __init__(self, token: str | None) -> None:
        self._token = token
        self._turn = asyncio.Lock()
        self._waiting = 0

    @property
    def is_on(self) -> bool:
        """Whether a token is wanted."""
        return self._token is not None

    def is_right(self, given: object) -> bool:
        """Whether this is the token; compared in constant time."""
        if self._token is None or not isinstance(given, str):
            return self._token is None
        return hmac.compare_digest(given.encode(errors="replace"), self._token.encode())

    async def look(self, given: object) -> bool:
        """Whether a token lets its sender in."""
        if self._waiting >= GUESSES_WAITING:
            return False
        self._waiting += 1
        try:
            async with self._turn:
                right = self.is_right(given)
                if not right:
                    await asyncio.sleep(GUESS_S)
                return right
        finally:
            self._waiting -= 1


def why_not(listens_on: str, host: str, origin: str | None) -> str | None:
    """Why a request with this Host and Origin may not come in; None if it may."""
    if is_loopback(listens_on) and not is_ours(listens_on, host):
        return f"this server is not {host[:100]!r}"
    if origin is not None and split(origin).netloc.lower() != host.lower():
        return "pages of other sites may not use this server"
    return None


def is_ours(listens_on: str, host: str) -> bool:
    """Whether a Host names this machine, for a server that listens on this address.

    Where other machines can reach it, any address does, and the machine's own name in its usual forms.
    """
    name = split(f"//{host}").hostname or ""
    if name in ("localhost", listens_on.lower()):
        return True
    try:
        address = ipaddress.ip_address(name)
    except ValueError:
        own = socket.gethostname().lower()
        short = own.partition(".")[0]
        return not is_loopback(listens_on) and name in (own, short, f"{short}.local")
    return address.is_loopback or not is_loopback(listens_on)


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
