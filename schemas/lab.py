"""A lab: its devices, each with its driver or address and its limits."""

from datetime import time
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, StringConstraints, model_validator

from .contract import ContractType, Name
from .model import Model, no_items
from .quantity import Duration, seconds

Number = int | float | str
HIDDEN = "***"


def _reachable(url: str) -> str:
    from urllib.parse import urlsplit  # most labs have no url

    try:
        has_port = urlsplit(url).port != 0
    except ValueError:
        has_port = False
    if not has_port:
        raise ValueError(f"{url} is no address: a port is a number from 1 to 65535")
    return url


Url = Annotated[str, Field(pattern=r"^https?://[^/\s]+/?$"), AfterValidator(_reachable)]


class Limit(Model):
    """A narrower range for one parameter on this bench; a bare number is in the contract's unit."""

    minimum: Number | None = None
    maximum: Number | None = None


class LabDevice(Model):
    """One device: served by this machine (`driver`) or reached at an address (`url`)."""

    contract: ContractType
    driver: str | None = None
    config: dict[str, Any] = Field(default_factory=dict)
    python: str | None = None
    port: int | None = Field(default=None, ge=1, le=65535)
    url: Url | None = None
    token: str | None = None
    limits: dict[str, Limit] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _driver_or_url(self) -> "LabDevice":
        if (self.driver is None) == (self.url is None):
            raise ValueError("give either `driver` (served by this machine) or `url`")
        if self.python is not None and self.driver is None:
            raise ValueError(
                "`python` starts the server of a `driver`; with `url` it runs elsewhere"
            )
        return self


class RosNames(Model):
    """The lab's names in ROS.

    `package` is that of the generated interfaces. `aliases`: a name used by the paper's programs -> the
    device behind it, or any name -> `device.action`. `launch`: what `/launch` may start, by name.
    `action_timeout`: an action may take ten times as long as its contract states, and at least this.
    """

    package: str = Field(default="labrun_interfaces", pattern=r"^[a-z](_?[a-z0-9]+)*$")
    aliases: dict[str, str] = Field(default_factory=dict)
    launch: dict[str, str] = Field(default_factory=dict)
    action_timeout: Duration = "2 min"


NotifyEvent = Literal["failed", "question", "done", "device_lost"]
Hour = Annotated[str, StringConstraints(pattern=r"^(([01]\d|2[0-3]):[0-5]\d)?$")]


class Receiver(Model):
    """Who is told, and of what.

    `to` is an address as Apprise has it, or `$NAME` for one that is in the environment; `{FILE}` in it stands
    for the first line of a file, such as a password.
    """

    to: Annotated[str, StringConstraints(min_length=2, max_length=500)]
    on: list[NotifyEvent] = Field(default=["failed", "question"], max_length=4)


class LabNotify(Model):
    """Who is told what of every run; `on` is for those in `to` that are mere addresses.

    Between `quiet_from` and `quiet_to`, hours of this computer's clock, messages wait.
    """

    to: list[str | Receiver] = Field(min_length=1, max_length=20)
    on: list[NotifyEvent] = Field(default=["failed", "question"])
    quiet_from: Hour = ""
    quiet_to: Hour = ""

    @property
    def receivers(self) -> list[Receiver]:
        """Each with what it is told of."""
        return [Receiver(to=o, on=self.on) if isinstance(o, str) else o for o in self.to]

    def addresses(self, event: NotifyEvent | None) -> list[str]:
        """Of those who are told of an event; of all for None, what a protocol says."""
        return [one.to for one in self.receivers if event is None or event in one.on]

    def is_quiet(self, now: time) -> bool:
        """True between the hours in which nobody wants to hear; they may go over midnight."""
        if not self.quiet_from or not self.quiet_to:
            return False
        begin, over = time.fromisoformat(self.quiet_from), time.fromisoformat(self.quiet_to)
        return begin <= now < over if begin <= over else now >= begin or now < over


class Lab(Model):
    """The devices of one laboratory, by name.

    `folders`, from where the lab's file lies: their tables and protocols may be named by any
    protocol, beside those in its own folder.
    """

    name: str = "lab"
    summary: str = ""
    simulated: bool = False
    contracts: list[str] = Field(default_factory=no_items)
    folders: list[str] = Field(default_factory=no_items)
    devices: dict[Name, LabDevice] = Field(min_length=1)
    start_timeout: Duration = "60 s"
    stop_grace: Duration = "10 s"
    notify: LabNotify | None = None
    ros: RosNames | None = None

    @model_validator(mode="before")
    @classmethod
    def _said_in_config(cls, data: Any) -> Any:
        """A device whose `config` says its actions has a contract of its own, named after it."""
        devices = data.get("devices") if isinstance(data, dict) else None
        if not isinstance(devices, dict):
            return data
        return {**data, "devices": {name: _named(name, one) for name, one in devices.items()}}

    @property
    def start_timeout_s(self) -> float:
        """How long a device server may take to start, or to answer for the first time, or again."""
        return seconds(self.start_timeout)

    @property
    def stop_grace_s(self) -> float:
        """How long a device may take to become safe, and then to close, when its server ends."""
        return seconds(self.stop_grace)


def without_secrets(lab: dict[str, Any]) -> dict[str, Any]:
    """A lab as it was read, without what only its owner may know: it is changed in place."""
    lab.pop("notify", None)  # addresses have passwords in them
    for device in (lab.get("devices") or {}).values():
        device.pop("token", None)
        config = device.get("config") or {}
        if device.get("driver") == "apprise":
            config["to"] = dict.fromkeys(config.get("to") or (), HIDDEN)
        if "password" in config:
            config["password"] = HIDDEN
        config |= (
            {"headers": dict.fromkeys(config["headers"], HIDDEN)} if config.get("headers") else {}
        )
        for step in config.get("login") or ():
            step |= {"send": HIDDEN} if "send" in step else {}
    return lab


def _named(name: Any, device: Any) -> Any:
    if not isinstance(device, dict) or "contract" in device or "driver" not in device:
        return device
    config = device.get("config")
    said = isinstance(config, dict) and "actions" in config
    return {**device, "contract": f"{str(name).lower()}@1"} if said else device
