"""Tasks have a name and an owner, and none dies in silence."""

import asyncio
import gc
import logging
from pathlib import Path

import pytest

from labrun.system.tasks import end, keep, spawn


async def broken(fault=RuntimeError):
    raise fault("the pump is dry")


def test_a_task_has_its_name_and_gives_its_result():
    async def story():
        task = spawn("sum", asyncio.sleep(0, 3))
        return task.get_name(), await task

    assert asyncio.run(story()) == ("sum", 3)


def test_a_fault_is_logged_with_its_traceback_although_its_owner_handles_it(caplog):
    async def story():
        with pytest.raises(RuntimeError):
            await spawn("watering", broken())

    asyncio.run(story())

    (record,) = caplog.records
    assert record.getMessage() == "watering failed"
    assert record.exc_info is not None and "pump is dry" in str(record.exc_info[1])


def test_what_is_expected_or_cancelled_is_not_logged(caplog):
    async def story():
        with pytest.raises(LookupError):
            await spawn("asking", broken(KeyError), expected=(LookupError,))
        await end(spawn("waiting", asyncio.sleep(60)), None)

    asyncio.run(story())

    assert caplog.records == []


def test_a_task_whose_owner_forgets_it_runs_to_its_end():
    ended = asyncio.Event()

    async def work():
        await asyncio.sleep(0.01)
        ended.set()

    async def story():
        spawn("forgotten", work())
        gc.collect()
        await asyncio.wait_for(ended.wait(), 500)

    asyncio.run(story())


def test_a_loop_that_fails_begins_again_and_says_why(caplog):
    rounds = []

    async def work():
        rounds.append(len(rounds))
        if len(rounds) < 3:
            raise RuntimeError(f"round {len(rounds)}")

    asyncio.run(_awaited(work))

    assert rounds == [0, 1, 2]
    assert [r.getMessage() for r in caplog.records] == [
        "polling failed; it begins again in 0 s"
    ] * 2
    assert all(r.levelno == logging.ERROR and r.exc_info for r in caplog.records)


async def _awaited(work):
    await keep("polling", work, again_s=0)


def test_a_kept_loop_ends_when_its_owner_cancels_it():
    async def story():
        task = keep("for ever", lambda: asyncio.sleep(3600))
        await asyncio.sleep(0)
        await end(task)
        return task.cancelled()

    assert asyncio.run(story())


def test_the_end_waits_for_what_a_task_does_last():
    said = []

    async def work():
        try:
            await asyncio.sleep(3600)
        finally:
            await asyncio.sleep(0.01)
            said.append("closed")

    async def story():
        task = spawn("writing", work())
        await asyncio.sleep(0)
        await end(task)

    asyncio.run(story())

    assert said == ["closed"]


def test_nothing_else_creates_a_task():
    root = Path(__file__).parents[2]
    source = [p for part in ("drivers", "engine", "reduction", "schemas", "system", "web")
              for p in (root / part).rglob("*.py") if "node_modules" not in p.parts]  # fmt: skip
    creating = [p for p in source if ".create_task(" in p.read_text("utf-8")]

    assert [p.relative_to(root).as_posix() for p in creating] == ["system/tasks.py"]
