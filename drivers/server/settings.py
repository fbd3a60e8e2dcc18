"""The settings of a device server: the file that `labrun.drivers.server.serve` reads."""

from typing import Any

from pydantic import Field

from ...schemas.contract import Name
from ...schemas.model import Model


class DeviceSettings(Model):
    """One device: its contract, its driver and its limits."""

    contract: dict[str, Any]
    driver: str
    config: dict[str, Any] = Field(default_factory=dict)
    limits: dict[str, Any] = Field(default_factory=dict)


class TlsFiles(Model):
    """Certificate and key, as PEM files."""

    certificate: str
    key: str


class ServerSettings(Model):
    """A device server.

    `folder` holds the ledger; `world` is what simulated twins share; `base` is the folder that
    `./my_driver.py:Class` is relative to (the lab file's), `python` the interpreter that
    serves. With `own_token` a server that was given no token makes one for this user's programs.
    With `idle_exit_s` the server exits when no client has been connected for that long and every
    device is safe, but not while the process `owner_pid` is running. With `ends_with_owner` it
    exits as soon as that process has ended and nobody holds a device. `stop_grace_s` is how long a
    device may take to become safe. With `patient` it serves without the devices whose instruments
    are out of reach, and goes on trying to open them.
    """

    devices: dict[Name, DeviceSettings] = Field(min_length=1)
    folder: str
    world: str | None = None
    base: str = "."
    python: str | None = None
    host: str = "127.0.0.1"
    port: int = Field(default=0, ge=0, le=65535)
    token: str | None = Field(default=None, min_length=1)
    own_token: bool = False
    patient: bool = False
    tls: TlsFiles | None = None
    owner_pid: int | None = None
    ends_with_owner: bool = False
    stop_grace_s: float = Field(default=10.0, gt=0)
    idle_exit_s: float | None = Field(default=None, gt=0)
