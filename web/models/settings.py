"""Settings of the bench, and the session of a browser."""

from typing import Annotated

from pydantic import Field, StringConstraints

from .base import ApiModel

Line = Annotated[str, StringConstraints(max_length=300)]


class Settings(ApiModel):
    """What can be set; each of `checklists` is shown before a run with that danger."""

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
