"""A lab says which device stands where, by which driver or address, with which limits."""

from typing import Any

from pydantic import Field, model_validator

from .contract import ContractType, Name
from .model import Model

Number = int | float | str


class Limit(Model):
    """A narrower range for one parameter on this bench; a bare number is in the contract's unit."""

    minimum: Number | None = None
    maximum: Number | None = None


class LabDevice(Model):
    """One device: served by this machine (`driver`) or reached at an address (`url`)."""

    contract: ContractType
    driver: str | None = None
    config: dict[str, Any] = Field(default_factory=dict)
    port: int | None = Field(default=None, ge=1, le=65535)
    url: str | None = Field(default=None, pattern=r"^https?://[^/\s]+/?$")
    token: str | None = None
    limits: dict[str, Limit] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _driver_or_url(self) -> "LabDevice":
        if (self.driver is None) == (self.url is None):
            raise ValueError("give either `driver` (served by this machine) or `url`")
        return self


class RosNames(Model):
    """How the lab is called in ROS.

    `package` is that of the generated interfaces. `aliases`: a name of the paper's programs -> the
    device behind it, or any name -> `device.action`. `launch`: what `/launch` may start, by name.
    """

    package: str = Field(default="labrun_interfaces", pattern=r"^[a-z](_?[a-z0-9]+)*$")
    aliases: dict[str, str] = Field(default_factory=dict)
    launch: dict[str, str] = Field(default_factory=dict)


class Lab(Model):
    """The devices of one laboratory, by name."""

    name: str = "lab"
    summary: str = ""
    simulated: bool = False
    contracts: list[str] = Field(default_factory=list)
    devices: dict[Name, LabDevice] = Field(min_length=1)
    ros: RosNames | None = None
