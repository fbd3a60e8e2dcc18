"""Runs found again and compared; samples; one number over many runs."""

from pydantic import Field

from .base import ApiModel
from .runs import RunSummary


class FoundRun(RunSummary):
    """A run with what it is found by."""

    samples: list[str]
    tags: list[str]
    note: str


class FoundRuns(ApiModel):
    """Some of the runs for which a search holds, newest first."""

    runs: list[FoundRun]
    total: int = Field(description="How many there are, in all.")
    all: int = Field(description="How many runs there are without a search.")
    numbers: list[str] = Field(description="Names for `values` that some of these runs have.")


class RunLabels(ApiModel):
    """What people say of a run beside its protocol."""

    sample: str = Field(default="", max_length=80)
    tags: list[str] = Field(default_factory=list, max_length=30)
    note: str = Field(default="", max_length=2000)


class RunSnapshot(ApiModel):
    """A picture of the bench that a person took into a run."""

    file: str = Field(description="In the run's folder.")
    device: str
    by: str
    at: str


class TakeSnapshot(ApiModel):
    """With which camera."""

    device: str


class RunNumber(ApiModel):
    """A number that a run came to; `out` beyond the limits."""

    run: str
    protocol: str
    began_at: str
    value: float
    out: bool


class RunNumbers(ApiModel):
    """One number over runs, oldest first; no mean, and no computed limits, for fewer than three."""

    name: str
    unit: str
    runs: list[RunNumber]
    low: float | None
    mean: float | None
    high: float | None


class Compared(ApiModel):
    """Runs beside each other: every list has one item for each, in the order of `runs`."""

    runs: list[FoundRun]
    params: dict[str, list[str]] = Field(
        description="Those that differ; empty where a run has none."
    )
    same: int = Field(description="How many parameters do not differ.")
    lines: list[list[str]] = Field(description="A diff with the first run's protocol.")
    values: dict[str, list[float | None]]
    units: dict[str, str]
    took_s: list[float | None]
    seconds: dict[str, list[float | None]] = Field(description="Median of each action that worked.")
    failures: dict[str, list[int]]


class Sample(ApiModel):
    """A sample, and how often it was measured."""

    name: str
    runs: int
    last_at: str
