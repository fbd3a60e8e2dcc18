"""Settings of the bench, and the session of a browser."""

import re
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, model_validator

from .base import ApiModel

Line = Annotated[str, StringConstraints(max_length=300)]


Event = Literal["question", "failed", "done", "device_lost"]
Hour = Annotated[str, StringConstraints(pattern=r"^(([01]\d|2[0-3]):[0-5]\d)?$")]


class Receiver(ApiModel):
    """Who hears of what. `chat`: an incoming hook that takes `{"text": ...}`; `webhook`: a program."""

    kind: Literal["mail", "chat", "webhook"]
    to: Annotated[str, StringConstraints(min_length=3, max_length=500)]
    events: list[Event] = Field(max_length=4)

    @model_validator(mode="after")
    def _is_an_address(self) -> "Receiver":
        if self.kind == "mail" and not re.fullmatch(r"[^@\s<>,]+@[^@\s<>,]+", self.to):
            raise ValueError(f"{self.to} is not a mail address")
        if self.kind != "mail" and not self.to.startswith(("http://", "https://")):
            raise ValueError(f"{self.to}: the address of a {self.kind} begins with https://")
        return self


class Mail(ApiModel):
    """The server that takes mail; the password is in a file that only this account can read."""

    host: Line = "localhost"
    port: int = Field(default=25, ge=1, le=65535)
    tls: bool = False
    user: Line = ""
    password_file: Line = ""
    sender: Line = ""


class Settings(ApiModel):
    """What can be set; each of `checklists` is shown before a run with that danger.

    Between `quiet_from` and `quiet_to` (hours of this machine's clock) messages wait.
    """

    bench: Line = "bench"
    operators: list[Line] = Field(default_factory=list, max_length=200)
    checklists: dict[Line, list[Line]] = Field(
        default_factory=lambda: {
            "laser": ["enclosure closed", "nobody in the beam path", "sample fixed"],
            "heat": ["nothing flammable near", "guard closed"],
            "pressure": ["lines checked", "shield closed"],
        },
        max_length=20,
    )
    step_sizes_mm: list[Annotated[float, Field(gt=0, le=100)]] = Field(
        default_factory=lambda: [0.1, 1.0, 10.0], min_length=1, max_length=8
    )
    receivers: list[Receiver] = Field(default_factory=list, max_length=20)
    mail: Mail = Field(default_factory=Mail)
    quiet_from: Hour = ""
    quiet_to: Hour = ""


class TestMessage(ApiModel):
    """A receiver to try, with settings that may not be saved yet."""

    receiver: Receiver
    mail: Mail


class About(ApiModel):
    """What this server is, and where it stores its data."""

    labrun: str
    python: str
    lab: str
    lab_file: str | None
    simulated: bool
    protocols: str
    runs: str
    demo: bool


class AllSettings(ApiModel):
    """What can be set and what cannot."""

    settings: Settings
    about: About


class SignIn(ApiModel):
    """The token with which the server was started, if any."""

    token: str = Field(max_length=1000)


class Session(ApiModel):
    """`server_time_ms`: the clock by which `X-Deadline` counts; compare it with your own clock."""

    signed_in: bool
    token_needed: bool
    server_time_ms: float
    demo: bool
    labrun: str
