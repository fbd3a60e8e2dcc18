"""Settings of the bench, and the session of a browser."""

import re
from typing import Annotated, Any
from urllib.parse import quote

from pydantic import Field, StringConstraints, model_validator

from ...schemas.lab import Hour, LabNotify, Receiver
from .base import ApiModel

Line = Annotated[str, StringConstraints(max_length=300)]


class Settings(ApiModel):
    """What can be set; each of `checklists` is shown before a run with that danger.

    `by_hand_s`: an action by hand is cancelled after ten times as long as its contract states, and
    not before so many seconds. `look_every_s`: how often a live picture is taken, while somebody looks;
    `look_for_min`: after so long it ends, until somebody wants it again. `receivers`, `quiet_from` and
    `quiet_to` are the lab's `notify`.
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
    by_hand_s: float = Field(default=120.0, ge=1, le=604_800)
    look_every_s: float = Field(default=1.0, ge=0.2, le=3600)
    look_for_min: float = Field(default=10.0, ge=0.1, le=10_080)
    receivers: list[Receiver] = Field(default_factory=list, max_length=20)
    quiet_from: Hour = ""
    quiet_to: Hour = ""

    @model_validator(mode="before")
    @classmethod
    def _as_apprise_has_it(cls, data: Any) -> Any:
        """Receivers by kind, with one mail server, as settings had them before, are addresses now."""
        if not isinstance(data, dict):
            return data
        mail = data.get("mail") or {}
        receivers = [_translated(one, mail) for one in data.get("receivers") or []]
        return {name: v for name, v in data.items() if name != "mail"} | {"receivers": receivers}

    @property
    def notify(self) -> LabNotify | None:
        """As it stands in a lab."""
        if not self.receivers:
            return None
        return LabNotify(
            to=list(self.receivers), quiet_from=self.quiet_from, quiet_to=self.quiet_to
        )


class TestMessage(ApiModel):
    """An address to try, which may not be saved yet."""

    to: Annotated[str, StringConstraints(min_length=2, max_length=500)]


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


def _translated(one: Any, mail: dict[str, Any]) -> Any:
    if not isinstance(one, dict) or "kind" not in one:
        return one
    to = str(one.get("to", ""))
    if one["kind"] == "mail":
        user, file = mail.get("user"), mail.get("password_file")
        login = f"{quote(user, safe='')}:{{{file}}}@" if user else ""
        host = f"{mail.get('host', 'localhost')}:{mail.get('port', 25)}"
        sender = quote(mail.get("sender") or to, safe="")
        to = f"mailto{'s' if mail.get('tls') else ''}://{login}{host}/?to={quote(to, safe='')}&from={sender}"
    else:
        to = re.sub("^http", "json", to, count=1)
        to += CHAT_ONLY * (one["kind"] == "chat")
    return {"to": to, "on": one.get("events", [])}


CHAT_ONLY = "?:message=text&:title=&:type=&:version=&:attachments="
"""The hook of a chat takes `{"text": ...}`, and nothing else."""
