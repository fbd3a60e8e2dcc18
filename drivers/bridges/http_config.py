"""What a lab says of a device with an HTTP interface: its requests, its login, where values are found.

See docs/how-to/instruments-in-yaml.md.
"""

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import AfterValidator, Field, model_validator

from ...schemas.contract import Contract, Effect, Name
from .answers import NUMBER_ERRORS, OWN
from .config import LISTED, WHOLE, ActionConfig, BridgeConfig, ConfigFault, Pattern, chosen, pattern
from .resource import Served
from .template import template_faults, texts

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
    headers: dict[str, str] = Field(default_factory=dict)
    answer: Pattern | None = None

    @model_validator(mode="after")
    def _one_method(self) -> "HttpAction":
        if len(chosen(self, METHODS)) != 1:
            raise ValueError(f"it needs one of {', '.join(METHODS)}, with a path: `get: /state`")
        if len(chosen(self, ("body", "form", "text"))) > 1:
            raise ValueError("one of `body`, `form` and `text` is sent, not several")
        return self

    def guessed_effect(self) -> Effect:
        """What asks returns something; many devices are also set by a GET."""
        return "pure" if self.get is not None and self.returns else "once"

    def used(self) -> Iterator[tuple[str, str]]:
        for key in (*METHODS, "body", "form", "text", "headers"):
            yield from texts(key, getattr(self, key))
        for schema in self.returns.values():
            yield "returns", str(schema.get("at", ""))


class HttpConfig(Served, BridgeConfig):
    """The config of `driver: http`; a returned value says `at: data.speed` where it is found."""

    own_keys = ("at", "header", *OWN)
    own_errors = {  # type: ignore[assignment] # noqa: RUF012
        "Refused": ("no", "The device refused it (status 400 to 499)"),
        "DeviceError": ("unknown", "The device failed (status 500 to 599)"),
        **NUMBER_ERRORS,
    }

    schemes = ("http://", "https://")

    headers: dict[str, str] = Field(default_factory=dict)
    login: HttpAction | None = None
    expired: Annotated[list[Annotated[int | str, AfterValidator(pattern)]], LISTED] = Field(
        default_factory=lambda: [401]
    )
    verify: bool | str = True
    user: str | None = None
    password: str = ""
    digest: bool = False
    hello: str | None = None
    actions: dict[Name, HttpAction] = Field(min_length=1)

    def known(self) -> dict[str, Any]:
        return self.login.returns if self.login is not None else {}

    def faults(self, contract: Contract, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        if self.login is None and "expired" in self.model_fields_set:
            yield ConfigFault(("expired",), "there is no `login` that would be done again", True)
        for key, text in self.login.used() if self.login is not None else ():
            for message in template_faults(text, {}):
                yield ConfigFault(("login", key), message)
        for name, text in self.headers.items():
            for one in WHOLE.findall(text):
                if one not in self.known():
                    message = f"{{{one}}}: nothing says it; what a `login` returns may stand here"
                    yield ConfigFault(("headers", name), message)
