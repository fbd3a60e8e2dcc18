"""A run's four numbers, from every place that tells them."""

import asyncio
from collections import Counter

from labrun.engine.commands.runs import row
from labrun.engine.index.entry import entry_of
from labrun.engine.journal.history import read_history
from labrun.engine.journal.journal import Follower, read_records
from labrun.web.library.timings import Timings
from labrun.web.report.journal_digest import read_digest
from labrun.web.runs.picture import Picture
from labrun.web.runs.run_views import detail, points
from labrun.web.runs.runs import Runs
from labrun.web.updates.updates import Updates

LOOP = "main/all"


def everywhere(folder):
    """Where -> plan, measured, failed, left; the holes are among them, as a fifth."""
    history = read_history(read_records(folder / "journal.jsonl"))
    told, digest, line = history.points(), read_digest(folder), row(entry_of(folder), folder.parent)
    api, page = asyncio.run(_served(folder))
    return {
        "journal": (told.plan, told.measured, told.failed, told.left, history.hole_count),
        "CLI": (line["plan"], line["measured"], line["failed"], line["left"], line["holes"]),
        "API": (api.total, api.measured, api.failed, api.left, api.holes),
        "page": page,
        "report": (*digest.points.model_dump().values(), digest.hole_count),
    }


async def _served(folder):
    runs = Runs(folder.parent, Timings(folder.parents[1] / "timings.json"), Updates())
    await runs.open()
    try:
        run = await runs.opened(folder.name)
        told, table = detail(run), points(run, LOOP, "", 0, 5000)
    finally:
        await runs.close()
    return told, _counted(table.total, table.status)


def _counted(total, statuses):
    found = Counter(statuses)
    left = total - found["ok"] - found["failed"]
    return total, found["ok"], found["failed"], left, found["failed"]


class Onlooker:
    """A page that stays open while engines come and go: it reads the journal as it grows."""

    def __init__(self, folder, outline):
        self.picture = Picture(folder / "journal.jsonl", outline)
        self.follower = Follower(folder / "journal.jsonl")

    def sees(self):
        for offset, record in self.follower.records():
            self.picture.read(offset, record)
        table = self.picture.tables[LOOP, ""]
        return _counted(table.total, table.columns(range(table.total))["status"])
