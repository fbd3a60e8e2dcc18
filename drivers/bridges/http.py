"""Devices with an HTTP interface, by aiohttp; what a lab says of them is in `http_config`."""

import ssl
from base64 import b64encode
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple
from urllib.parse import quote, urljoin

from ...schemas.contract import Action
from ...schemas.patterns import regular_expression
from ..driver import ActionFailed, GoalContext
from .answers import BadAnswer, value
from .bridge import Bridge, Values
from .channel import REASONS
from .config import WHOLE, chosen
from .data import answer_values, plainly
from .http_config import METHODS, HttpAction, HttpConfig
from .line_bridge import file_of
from .lines import NoAnswer
from .template import fill, filled

if TYPE_CHECKING:
    from aiohttp import ClientSession


class Answer(NamedTuple):
    """What came back, as bytes and as text, with its headers as lines; `asked` says for what."""

    asked: str
    status: int
    data: bytes
    text: str
    headers: list[str]


class Http(Bridge):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = HttpConfig
    _session: "ClientSession | None" = None

    async def ready(self, timeout_s: float) -> None:
        if self._session is not None:
            return
        from aiohttp import ClientSession, CookieJar, DigestAuthMiddleware, TCPConnector

        said: HttpConfig = self.config
        digest = [DigestAuthMiddleware(said.user or "", said.password)] if said.digest else []
        try:  # any answer shows that it is there; `hello` is a path that it has
            self._session = ClientSession(
                connector=TCPConnector(ssl=_trusted(said.verify)),
                cookie_jar=CookieJar(unsafe=True),  # a device's name is often its address
                middlewares=digest,
            )
            if said.login is not None:
                await self.greet(said.login)
            hello = HttpAction(get=said.hello or "/")
            told = await self._asked(hello, {}, {}, GoalContext("hello"))
            if said.hello is not None and told.status >= 400:
                raise OSError(f"{said.hello} answers with status {told.status}")
        except (ActionFailed, BadAnswer) as fault:
            raise OSError(f"{said.url} does not let it in: {fault}") from fault
        except (NoAnswer, OSError) as fault:
            own = "CERTIFICATE_VERIFY" in str(fault) and "; `verify: device.pem` trusts its own"
            raise OSError(f"{said.url} cannot be reached: {fault}{own or ''}") from fault

    async def drop(self) -> None:
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    async def perform(
        self, said: HttpAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        params, login = self.params(said, action), self.config.login
        told = await self._asked(said, params, values, goal)
        if login not in (None, said) and any(
            one == told.status if isinstance(one, int) else self.pattern(one).search(told.text)
            for one in self.config.expired
        ):
            await self.greet(login)  # nothing was done
            told = await self._asked(said, params, values, goal)
        self._refuse(told, said)
        returns = self.returns(said, action)
        try:
            above = {n: _in_header(told.headers, s) for n, s in returns.items() if "header" in s}
            returns = {name: one for name, one in returns.items() if name not in above}
            if file := next((n for n, s in returns.items() if s.get("format") == "path"), None):
                return above | {file: file_of(goal, file, values, told.data)}
            for name, schema in returns.items():
                if "at" in schema:
                    at = fill(str(schema["at"]), values, params, goal.id)
                    returns[name] = {**schema, "at": at}
            wanted = self.pattern(said.answer) if said.answer is not None else None
            json = bool(returns) and (wanted is None or any("at" in s for s in returns.values()))
            return above | answer_values(told.text, returns, wanted, json=json)
        except BadAnswer as fault:
            raise BadAnswer(f"{told.asked} and answered {told.text[:80]!r}: {fault}") from fault

    async def _asked(
        self, said: HttpAction, params: Values, values: Values, goal: GoalContext
    ) -> Answer:
        from aiohttp import ClientError, ClientTimeout

        config: HttpConfig = self.config
        put = {"given": self.known | values, "params": params, "goal": goal.id}
        (method,) = chosen(said, METHODS)
        path, more = _path(getattr(said, method), put), dict[str, Any]()
        if said.body is not None:
            more["json"] = filled(said.body, **put)
        if said.form is not None:
            more["data"] = {name: plainly(one) for name, one in filled(said.form, **put).items()}
        if said.text is not None:
            more["data"] = fill(said.text, **put)
        known = {n: t for n, t in config.headers.items() if self.known or not WHOLE.search(t)}
        headers = {name: fill(one, self.known, {}, "") for name, one in known.items()}
        headers |= {name: fill(one, **put) for name, one in said.headers.items()}
        if config.user is not None and not config.digest:
            basic = b64encode(f"{config.user}:{config.password}".encode()).decode()
            headers = {"Authorization": f"Basic {basic}", **headers}
        moves = method == "get" and not any(one in range(300, 400) for one in config.expired)
        asked = f"{self.place.device} was asked to {method.upper()} {path}"
        if self._session is None:
            raise OSError("the connection was closed")
        limit_s = self.timeout_s(said)
        try:
            async with self._session.request(
                method, config.url + path, headers=headers, allow_redirects=moves,
                timeout=ClientTimeout(total=limit_s), **more,
            ) as got:  # fmt: skip
                data = await got.read()
        except TimeoutError as fault:
            raise NoAnswer(f"{asked} and did not answer within {limit_s:g} s") from fault
        except ClientError as fault:
            why = REASONS.get(getattr(fault, "errno", None) or 0, fault or type(fault).__name__)
            raise OSError(f"{asked}: {why}") from fault
        lines = [f"{name}: {one}" for name, one in got.headers.items()]
        if place := got.headers.get("Location"):  # as a path of this device's own
            lines.insert(0, f"Location: {urljoin(str(got.url), place).removeprefix(config.url)}")
        text = data.decode(got.charset or "utf-8", "backslashreplace")
        return Answer(asked, got.status, data, text, lines)

    def _refuse(self, told: Answer, said: HttpAction) -> None:
        words = f"{told.asked} and answered with status {told.status}: {told.text[:200].strip()}"
        if told.status == 401 and any(
            "www-authenticate: digest" in one.lower() for one in told.headers
        ):
            words += "; it wants `user`, `password` and `digest: true`"
        if known := self.named(said, told.status, told.text):
            raise ActionFailed(known[0], words, known[1].happened)
        if told.status >= 500:
            raise ActionFailed("DeviceError", words, "unknown")
        if told.status >= 300:
            raise ActionFailed("Refused", words, "no")


def _trusted(verify: bool | str) -> "ssl.SSLContext | bool":
    """By which certificate the device is known; raises OSError."""
    if isinstance(verify, bool):
        return verify
    try:
        return ssl.create_default_context(cafile=Path(verify).expanduser())
    except OSError as fault:  # it is not there, or none; the library does not say which file
        raise OSError(f"`verify: {verify}` is no certificate: {fault}") from fault


def _path(template: str, put: Values) -> str:
    """Only what stands first may be a path, one that the device gave; other values are parts of one."""
    first = match[0] if (match := WHOLE.match(template)) else ""
    rest = fill(template.removeprefix(first), **put, escape=partial(quote, safe=""))
    return fill(first, **put) + rest


def _in_header(headers: list[str], schema: dict[str, Any]) -> Any:
    """What the group of a pattern is, in the line of a header that it matches; raises BadAnswer."""
    wanted = regular_expression(f"(?i:{schema['header']})")
    found = next((one for one in map(wanted.fullmatch, headers) if one is not None), None)
    if found is None:
        raise BadAnswer(f"none of its headers matches {schema['header']!r}: {', '.join(headers)}")
    return value(found[1 if wanted.groups else 0], schema)
