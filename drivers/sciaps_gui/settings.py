"""A lab's settings for an analyser whose program is operated by mouse and keyboard."""

from typing import Literal

from pydantic import Field

from ...schemas.model import Model


class SciapsGuiSettings(Model):
    """`buttons`: of `labrun record-program --buttons`; `cache` and `exports`: the program's folders.

    `export_path` is what is typed into the program for `exports`, where that reads otherwise.
    `delete` removes from the cache what was exported, once its spectrum is safe: with the program's
    own button, or as a file.
    """

    buttons: str
    cache: str
    exports: str
    export_path: str | None = None
    title: str | None = None
    spectrum: str = "*1.csv"
    cache_entry: str = "*"
    channels: int | None = Field(default=None, gt=0)
    delete: Literal["never", "button", "file"] = "never"
    sync: bool = False
    measure_s: float = Field(default=20, gt=0, le=600)
    hang_s: float = Field(default=30, ge=0, le=600)
    busy_s: float = Field(default=60, gt=0, le=600)
    dialog_s: float = Field(default=10, gt=0, le=120)
    export_s: float = Field(default=60, gt=0, le=600)
    settle_s: float = Field(default=1, gt=0, le=60)
