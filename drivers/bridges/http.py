"""Devices with an HTTP interface: JSON in and out.

See docs/how-to/instruments-in-yaml.md.
"""

import asyncio
import json
import ssl
from base64 import b64encode
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar
from urllib.parse import quote, urljoin

from pydantic import Field, field_validator, model_validator

from ...schemas.contract import Action, Contract, Effect, Name
from ...schemas.patterns import regular_expression
from ..driver import ActionFailed, GoalContext
from .answers import OWN, BadAnswer, value
from .answers import values as values_of
from .bridge import Bridge, Values
from .by_action import ByAction, filled, texts
from .config import WHOLE, ActionConfig, ConfigFault, pattern
from .data import found_at, plainly
from .line_bridge import file_of
from .lines import NoAnswer
from .template import fill, template_faults

if TYPE_CHECKING:
    from aiohttp import ClientSession

METHODS = ("get", "put", "post", "patch", "delete")


class HttpAction(ActionConfig):
    """One of get, put, post, patch or delete, with a path.

    `body` is sent as JSON, `form` as a web page's form, `text` as it is.
    """

    get: str | None = None
    put: str | None = None
    post: str | None = None
    patch: str | None = None
    delete: str | None = None
    body: Any = None
    form: dict[str, Any] | None = None
    text: str | None = None
    answer: str | None = None

    @field_validator("answer")
    @classmethod
    def _is_a_pattern(cls, value: str | None) -> str | None:
        return pattern(value)

    @model_validator(mode="after")
    def _one_method(self) -> "HttpAction":
        if len([method for method in METHODS if getattr(self, method) is not None]) != 1:
            raise ValueError(f"it needs one of {', '.join(METHODS)}, with a path: `get: /state`")
        if len([one for one in (self.body, self.form, self.text) if one is not None]) > 1:
            raise ValueError("one of `body`, `form` and `text` is sent, not several")
        return self

    @property
    def request(self) -> tuple[str, str]:
        """Method and path."""
        return next((m, str(getattr(self, m))) for m in METHODS if getattr(self, m) is not None)

    def guessed_effect(self) -> Effect:
        return "pure" if self.get is not None else "once"

    def used(self) -> Iterator[tuple[str, str]]:
        yield self.request
        yield from texts("body", self.body)
        yield from texts("form", self.form)
        yield from texts("text", self.text)
        for schema in self.returns.values():
            yield "returns", str(schema.get("at", ""))


class HttpConfig(ByAction):
    """The config of `driver: http`; a returned value says `at: data.speed` where it is found."""

    own_keys = ("at", "header", *OWN)
    own_errors = {  # type: ignore[assignment] # noqa: RUF012
        "Refused": ("no", "The device refused it (status 400 to 499)"),
        "DeviceError": ("unknown", "The device failed (status 500 to 599)"),
        "BadAnswer": ("unknown", "The answer is not what this action returns"),
        "Overload": ("yes", "The device answered that the value is beyond its range"),
        "NotANumber": ("yes", "The device answered that it has no value"),
    }

    url: str
    headers: dict[str, str] = Field(default_factory=dict)
    login: HttpAction | None = None
    expired: list[int | str] = Field(default_factory=lambda: [401])
    verify: bool | str = True
    user: str | None = None
    password: str = ""
    digest: bool = False
    hello: str | None = None
    actions: dict[Name, HttpAction] = Field(min_length=1)
    status: list[str] = Field(default_factory=list)

    @field_validator("expired", mode="before")
    @classmethod
    def _are_patterns(cls, value: Any) -> Any:
        said = value if isinstance(value, list) else [value]
        return [pattern(one) if isinstance(one, str) else one for one in said]

    @field_validator("url")
    @classmethod
    def _is_an_address(cls, value: str) -> str:
        if not value.startswith(("http://", "https://")):
            raise ValueError(f"{value!r} is no address such as http://10.0.0.8:8080/api")
        return value.rstrip("/")

    @property
    def expired_moves(self) -> bool:
        """Whether a redirection means that nobody is logged in any more: then none is followed."""
        return any(isinstance(one, int) and 300 <= one < 400 for one in self.expired)

    def known(self) -> dict[str, Any]:
        return self.login.returns if self.login is not None else {}

    def faults(self, contract: Contract, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        if self.login is not None:
            for key, text in self.login.used():
                for message in template_faults(text, {}):
                    yield ConfigFault(("login", key), message)
        elif "expired" in self.model_fields_set:
            yield ConfigFault(("expired",), "there is no `login` that would be done again", True)
        for name, text in self.headers.items():
            asked = WHOLE.search(text)
            if self.login is not None:
                for message in template_faults(text, self.known()):
                    yield ConfigFault(("headers", name), message)
            elif asked is not None:
                message = f"{asked[0]}: nothing says it; what a `login` returns may stand here"
                yield ConfigFault(("headers", name), message)


class Http(Bridge):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = HttpConfig
    _session: "ClientSession | None" = None

    async def ready(self, timeout_s: float) -> None:
        if self._session is not None:
            return
        from aiohttp import ClientSession, CookieJar, DigestAuthMiddleware, TCPConnector

        said: HttpConfig = self.config
        try:  # any answer shows that it is there; `hello` is a path that it has
            self._session = ClientSession(
                connector=TCPConnector(ssl=_trusted(said.verify)),
                cookie_jar=CookieJar(unsafe=True),  # a device's name is often its address
                middlewares=(DigestAuthMiddleware(said.user or "", said.password),)
                if said.digest
                else (),
            )
            async with asyncio.timeout(timeout_s):
                if said.login is not None:
                    await self._log_in(said.login)
                url = said.url + (said.hello or "/")
                async with self._session.get(url, headers=self._headers()) as answer:
                    if said.hello is not None and answer.status >= 400:
                        raise OSError(f"{url} answers with status {answer.status}")
        except (ActionFailed, NoAnswer, BadAnswer) as fault:
            await self.drop()
            raise OSError(f"{said.url} does not let it in: {fault}") from fault
        except TimeoutError as fault:
            await self.drop()
            raise OSError(f"{self.config.url} does not answer within {timeout_s:g} s") from fault
        except OSError as fault:  # aiohttp's ClientError of a connection is one, too
            await self.drop()
            own = (
                "; `verify: device.pem` trusts its own"
                if "CERTIFICATE_VERIFY" in str(fault)
                else ""
            )
            raise OSError(f"{self.config.url} cannot be reached: {fault}{own}") from fault

    def _headers(self) -> dict[str, str]:
        said: HttpConfig = self.config
        headers = said.headers
        if said.login is not None:
            known = {n: text for n, text in headers.items() if self.known or not WHOLE.search(text)}
            headers = {name: fill(text, self.known, {}, "") for name, text in known.items()}
        if said.user is not None and not said.digest:
            basic = b64encode(f"{said.user}:{said.password}".encode()).decode()
            headers = {"Authorization": f"Basic {basic}", **headers}
        return headers

    async def _log_in(self, login: HttpAction) -> None:
        """What it answers may stand in headers and all that is sent: a token."""
        self.known = {}
        action = Action(returns={"properties": dict(login.returns)})
        self.known = await self.perform(login, action, {}, GoalContext("login"))

    async def drop(self) -> None:
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    async def perform(
        self, said: HttpAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        params = self.params(said, action)
        what, status, data, text, headers = await self._asked(said, params, values, goal)
        if self.config.login not in (None, said) and self._has_expired(status, text):
            await self._log_in(self.config.login)  # nothing was done
            what, status, data, text, headers = await self._asked(said, params, values, goal)
        self._refuse(what, said, status, text, headers)
        returns = self.config.written(action.returns.get("properties", {}), said.returns)
        above = {n: _in_header(headers, s) for n, s in returns.items() if "header" in s}
        returns = {name: schema for name, schema in returns.items() if name not in above}
        if file := next((n for n, s in returns.items() if s.get("format") == "path"), None):
            return above | {file: file_of(goal, file, values, data)}
        if said.answer is not None:
            return above | values_of(text, returns, regular_expression(said.answer))
        try:
            told = json.loads(text) if returns else None
        except ValueError as fault:
            if (
                len(returns) != 1
                or not text.strip()
                or any("at" in s for s in said.returns.values())
            ):
                raise BadAnswer(f"{what} and answered {text[:80]!r}, which is no JSON") from fault
            told = text  # a single value, as some devices answer
        at = {n: fill(str(s.get("at", "")), values, params, goal.id) for n, s in returns.items()}
        return above | {name: found_at(told, name, at[name], s) for name, s in returns.items()}

    async def _asked(
        self, said: HttpAction, params: Values, values: Values, goal: GoalContext
    ) -> tuple[str, int, bytes, str, list[str]]:
        """Send the request: what was asked, the status, the answer as bytes and text, its headers."""
        from aiohttp import ClientError

        values = self.known | values
        method, template = said.request
        path = _path(template, values, params, goal.id)
        body = filled(said.body, values, params, goal.id)
        more: dict[str, Any] = {"json": body} if body is not None else {}
        if said.form is not None:
            made = filled(said.form, values, params, goal.id)
            more = {"data": {name: plainly(value) for name, value in made.items()}}
        if said.text is not None:
            more = {"data": fill(said.text, values, params, goal.id)}
        url = self.config.url + path
        what = f"{self.place.device} was asked to {method.upper()} {path}"
        if self._session is None:
            raise OSError("the connection was closed")
        try:
            async with (
                asyncio.timeout(self.timeout_s(said)),
                self._session.request(
                    method,
                    url,
                    headers=self._headers(),
                    allow_redirects=method == "get" and not self.config.expired_moves,
                    **more,
                ) as got,
            ):
                data = await got.read()
                text = data.decode(got.charset or "utf-8", "backslashreplace")
                above = [f"{n}: {v}" for n, v in got.headers.items()]
                if place := got.headers.get("Location"):  # as a path of this device's own
                    place = urljoin(str(got.url), place).removeprefix(self.config.url)
                    above.insert(0, f"Location: {place}")
                return what, got.status, data, text, above
        except TimeoutError as fault:
            wait = f"{self.timeout_s(said):g} s"
            raise NoAnswer(f"{what} and did not answer within {wait}") from fault
        except ClientError as fault:
            raise OSError(f"{what}: {fault or type(fault).__name__}") from fault

    def _has_expired(self, status: int, text: str) -> bool:
        return any(
            one == status if isinstance(one, int) else regular_expression(one).search(text)
            for one in self.config.expired
        )

    def _refuse(
        self, what: str, said: HttpAction, status: int, text: str, headers: list[str]
    ) -> None:
        words = f"{what} and answered with status {status}: {text[:200].strip()}"
        if status == 401 and any("www-authenticate: digest" in one.lower() for one in headers):
            words += "; it wants `user`, `password` and `digest: true`"
        for name, error in {**self.config.errors, **said.errors}.items():
            if (error.code, error.answer) == (None, None) or error.code not in (None, status):
                continue
            if error.answer is None or regular_expression(error.answer).search(text):
                raise ActionFailed(name, words, error.happened)
        if status < 300:
            return
        if status < 500:
            raise ActionFailed("Refused", words, "no")
        raise ActionFailed("DeviceError", words, "unknown")


def _trusted(verify: bool | str) -> "ssl.SSLContext | bool":
    """By which certificate the device is known; raises OSError."""
    if isinstance(verify, bool):
        return verify
    try:
        return ssl.create_default_context(cafile=Path(verify).expanduser())
    except OSError as fault:  # it is not there, or none; the library does not say which file
        raise OSError(f"`verify: {verify}` is no certificate: {fault}") from fault


def _path(template: str, values: Values, params: Values, goal: str) -> str:
    """Only what stands first may be a path, one that the device gave; other values are parts of one."""
    first = match[0] if (match := WHOLE.match(template)) else ""
    rest = fill(template.removeprefix(first), values, params, goal, escape=partial(quote, safe=""))
    return fill(first, values, params, goal) + rest


def _in_header(headers: list[str], schema: dict[str, Any]) -> Any:
    """What the group of a pattern is, in the line of a header that it matches; raises BadAnswer."""
    wanted = regular_expression(f"(?i:{schema['header']})")
    found = next((one for one in map(wanted.fullmatch, headers) if one is not None), None)
    if found is None:
        raise BadAnswer(f"none of its headers matches {schema['header']!r}: {', '.join(headers)}")
    return value(found[1 if wanted.groups else 0], schema)
