"""Sessions of browsers: a cookie that only this server can make, or the token itself."""

import hmac
import secrets
import time
from collections.abc import Mapping
from hashlib import sha256
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any

from fastapi import Response

from ...drivers.server.gate import Brake
from ...drivers.server.same_user import is_own
from ...system.files import write_whole
from ..local.refusal import Refusal

COOKIE = "labrun_session"
LASTS_S = 30 * 24 * 3600
TICKET_S = 300
PASSED_ON = ("forwarded", "x-forwarded-for", "x-forwarded-host", "via")
"""What a proxy adds to the request of somebody else."""


class Sessions:
    """If `token` is given, everybody needs it; on loopback it may be omitted.

    A token that a person chose signs everybody out when it is changed; one that was `made` for this start
    does not.
    """

    def __init__(
        self, secret_file: Path, token: str | None, *, made: bool = False, secure: bool = False
    ) -> None:
        self._brake = Brake(token)
        self._made = made
        self._secure = secure
        secret = _secret(secret_file)
        self._secret = secret + sha256(("made" if made else token or "").encode()).digest()
        # Cookies know no ports: two servers of one machine would sign each other's browsers out.
        self._cookie = f"{COOKIE}_{sha256(secret).hexdigest()[:8]}"
        self._tickets: dict[str, float] = {}

    @property
    def token_needed(self) -> bool:
        """True if signing in is required."""
        return self._brake.is_on

    def may_enter(self, scope: Mapping[str, Any], headers: Mapping[str, str]) -> bool:
        """Whether a browser gets its session unasked: without a token everybody does; a token that was made
        here is not asked of the programs of our own user, who may read it in its file.
        """
        if not self._brake.is_on:
            return True
        peer, here = scope.get("client"), scope.get("server")
        if not self._made or peer is None or here is None:
            return False
        return not any(name in headers for name in PASSED_ON) and is_own(peer, here)

    async def admit(self, given: str) -> None:
        """Raise Refusal (401) for a wrong token, and for one of many that come at once."""
        if not await self._brake.look(given):
            words = "the token is wrong, or too many wrong ones came at once"
            hint = "use the one that labrun web was started with"
            raise Refusal(401, "WRONG_TOKEN", words, hint)

    def ticket(self) -> str:
        """Lets one browser in, once: the address that a browser is started with shows in `ps`."""
        made = secrets.token_urlsafe(24)
        self._tickets[made] = time.monotonic() + TICKET_S
        return made

    async def enters(self, given: str) -> bool:
        """Whether what stood in an address is the token, or a ticket that nobody has used."""
        if self._tickets.pop(given, 0.0) > time.monotonic():
            return True
        return await self._brake.look(given)

    def knows(self, cookies: Mapping[str, str], headers: Mapping[str, str]) -> bool:
        """Whether a request is signed in, by its cookie or as a program by `Authorization`."""
        given = bearer(headers)
        if given is not None and self._brake.is_on and self._brake.is_right(given):
            return True
        return self._is_ours(cookies.get(self._cookie, ""))

    def knows_raw(self, headers: Mapping[str, str]) -> bool:
        """The same for the headers of a WebSocket."""
        jar: SimpleCookie = SimpleCookie()
        try:
            jar.load(headers.get("cookie", ""))
        except CookieError:
            return False
        return self.knows({name: morsel.value for name, morsel in jar.items()}, headers)

    def set_cookie(self, response: Response) -> None:
        """Sign a browser in with a cookie that scripts cannot read and other sites cannot send."""
        until = str(int(time.time()) + LASTS_S)
        name = secrets.token_urlsafe(12)
        value = f"{name}.{until}.{self._sign(name, until)}"
        response.set_cookie(
            self._cookie, value, max_age=LASTS_S, httponly=True, samesite="strict", path="/",
            secure=self._secure,
        )  # fmt: skip

    def drop_cookie(self, response: Response) -> None:
        """Sign a browser out."""
        response.delete_cookie(self._cookie, path="/", httponly=True, samesite="strict")

    def _is_ours(self, cookie: str) -> bool:
        name, _, rest = cookie.partition(".")
        until, _, signature = rest.partition(".")
        if not signature or not hmac.compare_digest(
            signature.encode(), self._sign(name, until).encode()
        ):
            return False
        return until.isdecimal() and int(until) > time.time()

    def _sign(self, name: str, until: str) -> str:
        return hmac.new(self._secret, f"{name}.{until}".encode(), sha256).hexdigest()


def bearer(headers: Mapping[str, str]) -> str | None:
    """The token that a program has sent along, if any."""
    kind, _, given = headers.get("authorization", "").partition(" ")
    return given.strip() if kind.lower() == "bearer" else None


def _secret(path: Path) -> bytes:
    """The signing key of the cookies, stored so that a restart signs nobody out."""
    try:
        known = path.read_bytes()
        if len(known) >= 32:
            return known
    except OSError:
        pass
    made = secrets.token_bytes(32)
    write_whole(path, made, mode=0o600)
    return made
