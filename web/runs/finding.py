"""Runs found again and compared, from the engine's index of them."""

import asyncio
from dataclasses import asdict
from pathlib import Path

from pydantic import ValidationError

from ...engine.index.comparison import MOST, compare_runs
from ...engine.index.control_chart import chart, names
from ...engine.index.entry import Entry
from ...engine.index.index import find_runs
from ...engine.index.wanted import NotUnderstood
from ...engine.run.labels import read_labels, write_labels
from ...schemas.labels import Labels
from ...schemas.model import first_fault
from ..local.refusal import Refusal
from ..models import finding as models
from .quick import summary_from
from .runs import Runs


class Finding:
    """Looks for runs of one folder; of those that are open it tells the present state."""

    def __init__(self, runs: Runs) -> None:
        self._runs = runs

    async def found(self, text: str, offset: int, limit: int) -> models.FoundRuns:
        """Runs for which a search holds; raises Refusal (422) for one that means nothing."""
        entries = await self._entries(text)
        entries.reverse()
        window = entries[offset : offset + limit]
        return models.FoundRuns(
            runs=[self._run(entry) for entry in window], total=len(entries),
            all=len(await self._entries("")) if text else len(entries), numbers=names(window),
        )  # fmt: skip

    async def numbers(self, name: str, text: str, low: str, high: str) -> models.RunNumbers:
        """One number over the runs for which a search holds; raises Refusal (422)."""
        entries = await self._entries(text)
        try:
            made = chart(entries, name, low, high)
        except NotUnderstood as fault:
            raise Refusal(422, "NOT_UNDERSTOOD", str(fault)) from fault
        runs = [
            models.RunNumber(
                run=entry.run, protocol=entry.protocol, began_at=entry.began, value=number,
                out=made.is_out(number),
            )
            for entry, number in made.points
        ]  # fmt: skip
        return models.RunNumbers(
            name=name, unit=made.unit, runs=runs, low=made.low, mean=made.mean, high=made.high
        )

    async def compared(self, ids: list[str]) -> models.Compared:
        """Two to eight runs beside each other; raises Refusal."""
        if not 2 <= len(ids) <= MOST:
            raise Refusal(422, "WRONG_NUMBER", f"name two to {MOST} runs to compare")
        folders = [self._runs.place(id) for id in ids]
        made = await asyncio.to_thread(compare_runs, folders)
        told = {name: value for name, value in asdict(made).items() if name != "runs"}
        return models.Compared(runs=[self._run(entry) for entry in made.runs], **told)

    async def samples(self) -> list[models.Sample]:
        """Every sample, the one that was measured last first."""
        found: dict[str, models.Sample] = {}
        for entry in await self._entries("sample:"):
            for name in entry.samples.splitlines():
                before = found.pop(name, None)
                count = 1 + (before.runs if before is not None else 0)
                found[name] = models.Sample(name=name, runs=count, last_at=entry.began)
        return list(reversed(found.values()))

    async def of_sample(self, name: str) -> list[models.FoundRun]:
        """The runs of one sample, newest first."""
        entries = [
            one for one in await self._entries("sample:") if name in one.samples.splitlines()
        ]
        return [self._run(entry) for entry in reversed(entries)]

    def labels(self, id: str) -> models.RunLabels:
        """The labels of a run."""
        return models.RunLabels(**read_labels(self._runs.place(id)).model_dump())

    def label(self, id: str, asked: models.RunLabels) -> models.RunLabels:
        """Give a run these labels; raises Refusal (422)."""
        folder = self._runs.place(id)
        try:
            write_labels(folder, Labels.model_validate(asked.model_dump()))
        except ValidationError as fault:
            place = first_fault(fault).partition(":")[0]
            why = (
                "a tag is one word without commas or colons"
                if "tags" in place
                else first_fault(fault)
            )
            raise Refusal(422, "WRONG_LABEL", why) from fault
        except OSError as fault:
            why = f"the labels cannot be kept: {fault.strerror}"
            raise Refusal(507, "NO_ROOM", why) from fault
        return self.labels(id)

    async def _entries(self, text: str) -> list[Entry]:
        try:
            return await asyncio.to_thread(find_runs, Path(self._runs.folder), text)
        except NotUnderstood as fault:
            raise Refusal(422, "NOT_UNDERSTOOD", str(fault)) from fault

    def _run(self, entry: Entry) -> models.FoundRun:
        more = {
            "samples": entry.samples.splitlines(), "tags": entry.tags.splitlines(),
            "note": entry.note,
        }  # fmt: skip
        known = self._runs.one(entry.run) or self._runs.named(summary_from(entry))
        return models.FoundRun(**known.model_dump(), **more)
