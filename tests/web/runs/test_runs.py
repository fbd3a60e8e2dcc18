"""The folder of runs is watched whatever one run has in its journal, and whoever asks meanwhile."""

import asyncio
import json
import shutil
import sys

import pytest

from labrun.schemas import journal as j
from labrun.web.library.timings import Timings
from labrun.web.runs.open_run import OpenRun
from labrun.web.runs.picture import Picture
from labrun.web.runs.run_views import detail
from labrun.web.runs.runs import Runs
from labrun.web.updates.updates import Updates


class Bare:
    """A record without the fields that its kind has."""

    def __init__(self, kind):
        self.kind = kind

    def model_dump_json(self, **_):
        return json.dumps({"kind": self.kind})


@pytest.fixture
def runs(folder):
    """All runs beside the folder of the test's journal."""
    return Runs(folder.parent, Timings(folder.parent / "timings.json"), Updates())


async def until(true):
    async with asyncio.timeout(500):
        while not true():  # noqa: ASYNC110 - a folder tells nobody that it has changed
            await asyncio.sleep(0.01)


def test_an_end_without_a_fate_is_shown_as_damage_and_the_other_runs_are_watched(
    runs, folder, teller
):
    teller.started()
    good = folder.with_name("good")
    shutil.copytree(folder, good)
    teller.tell(Bare("finished"))

    async def story():
        await runs.open()
        try:
            bad = await runs.opened(folder.name)
            told = detail(bad)
            shutil.copytree(good, folder.with_name("later"))
            await until(lambda: runs.one("later"))
            return told
        finally:
            await runs.close()

    told = asyncio.run(story())

    assert (told.fate, told.protocol) == ("interrupted", "test")
    assert "record 3" in told.reason and "fate" in told.reason


def test_a_fault_of_ours_ends_one_run_on_the_page_and_is_in_the_log(
    folder, teller, caplog, monkeypatch
):
    teller.started().worked("main/a")
    monkeypatch.delattr(Picture, "_ended")
    run = OpenRun(folder, Timings(folder / "timings.json"), lambda id: None)
    asyncio.run(run.load())

    assert "record 4" in run.damage and "_ended" in run.damage
    assert any(record.exc_info for record in caplog.records if record.name == "labrun")


def test_a_run_that_grows_fast_can_be_told_at_any_time(folder, teller):
    (folder / "protocol.yaml").write_text(
        "labrun: 1\nname: test\ndevices: {libs: libs_analyzer@1}\ndefaults: {timeout: 60 s}\n"
        "steps:\n  - id: scan\n    foreach: {i: '${{ range(2000) }}'}\n    steps:\n"
        "      - id: inner\n        foreach: {k: '${{ range(2) }}'}\n"
        "        steps: [{id: go, do: libs.measure}]\n"
    )
    teller.started()

    async def story():
        run = OpenRun(folder, Timings(folder / "timings.json"), lambda id: None)
        await run.load()
        for outer in range(2000):
            teller.worked(f"main/scan/{outer}/inner/0/go")
        reading = asyncio.create_task(run.read())
        while not reading.done():
            detail(run)
            await asyncio.sleep(0)
        await reading
        return detail(run)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        told = asyncio.run(story())
    finally:
        sys.setswitchinterval(before)

    assert told.nodes["main/scan/*/inner/*/go"].ok == 2000


def test_a_run_that_is_opened_while_the_folder_is_scanned_stays_open(runs, folder, teller):
    teller.started().finished()

    async def story():
        await runs.open()
        try:
            other = folder.with_name("other")
            shutil.copytree(folder, other)
            _, run, _ = await asyncio.gather(
                runs.summaries(), runs.opened("other"), runs.summaries()
            )
            shutil.rmtree(other)
            await asyncio.gather(runs.summaries(), runs.summaries())
            return run.fate, [one.id for one in runs.all()]
        finally:
            await runs.close()

    assert asyncio.run(story()) == ("succeeded", [folder.name])


def test_a_record_that_lacks_its_time_leaves_the_records_before_it(folder, teller):
    teller.started().worked("main/0").tell(j.Phase(phase="finally:1"))
    text = teller.path.read_text().splitlines()

    async def story():
        run = OpenRun(folder, Timings(folder / "timings.json"), lambda id: None)
        await run.load()
        with teller.path.open("a", newline="\n") as file:
            file.write(teller._line(Bare("goal")))
        await run.read()
        return detail(run)

    told = asyncio.run(story())

    assert told.phase == "finally:1" and f"record {len(text) + 1}" in told.reason


def test_a_run_has_the_name_of_its_protocol_in_the_library_open_or_not(folder, teller):
    library = folder.with_name("protocols")
    teller.started()
    teller.finished()
    (folder / "run.json").write_text(json.dumps({"file": str(library / "deep" / "map.yaml")}))
    runs = Runs(folder.parent, Timings(folder.parent / "timings.json"), Updates(), library)

    async def story():
        await runs.open()
        try:
            before = runs.one(folder.name)
            await runs.opened(folder.name)
            return before, runs.one(folder.name)
        finally:
            await runs.close()

    before, opened = asyncio.run(story())

    assert before.file == opened.file == "deep/map.yaml"
