"""What a lab says about an analyser behind the paper's server."""

from pydantic import Field

from ...schemas.model import Model


class AecpSettings(Model):
    """`url` of the server; `exports`, its export folder as this machine sees it (a path or http://).

    `cache`, the folder of the program's own shots, lets a lost answer be cleared up afterwards.
    `export_path` is the path of the same export folder on the server's machine; if given, it is
    set on the server. `clock_s` is how far its clock is ahead of this machine's: its exports are known
    by the time in their names. `spectrum` is the name of the exported file that holds a shot's spectrum.
    """

    url: str = Field(default="http://localhost:1234", pattern=r"^https?://[^/\s]+/?$")
    exports: str
    cache: str | None = None
    export_path: str | None = None
    spectrum: str = "*1.csv"
    clock_s: float = Field(default=0, ge=-1e9, le=1e9)
    channels: int | None = Field(default=None, gt=0)
    connect_s: float = Field(default=15, gt=0, le=120)
    measure_s: float = Field(default=30, gt=0, le=600)
    export_s: float = Field(default=60, gt=0, le=600)
    locate_s: float = Field(default=60, gt=0, le=600)
    settle_s: float = Field(default=1, gt=0, le=60)
