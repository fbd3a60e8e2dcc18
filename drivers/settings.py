"""What a device server is told when it starts: the file that `python -m labrun.drivers.serve` reads."""

from typing import Any

from pydantic import Field

from ..schemas.contract import Name
from ..schemas.model import Model


class DeviceSettings(Model):
    """One device: the contract it keeps, by which driver, within which limits."""

    contract: dict[str, Any]
    driver: str
    config: dict[str, Any] = Field(default_factory=dict)
    limits: dict[str, Any] = Field(default_factory=dict)


class TlsFiles(Model):
    """Certificate and key, as files in PEM."""

    certificate: str
    key: str


class ServerSettings(Model):
    """A whole device server.

    `folder` keeps the ledger; `world` is what simulated twins share; `base` is the folder that
    `./my_driver.py:Class` is relative to (the lab file's). With `idle_exit_s` the server ends
    itself when nobody has been connected for that long and every device is safe, but not as long
    as the process `owner_pid` lives.
    """

    devices: dict[Name, DeviceSettings] = Field(min_length=1)
    folder: str
    world: str | None = None
    base: str = "."
    host: str = "127.0.0.1"
    port: int = Field(default=0, ge=0, le=65535)
    token: str | None = Field(default=None, min_length=1)
    tls: TlsFiles | None = None
    owner_pid: int | None = None
    idle_exit_s: float | None = Field(default=None, gt=0)
