"""A text that cannot be looked at in time is given up, and what is asked next finds a fresh process."""

import asyncio

import pytest

from labrun.web.library.text_check import TextCheck
from labrun.web.local.refusal import Refusal
from labrun.web.local.workers import Worker
from labrun.web.models.protocols import CheckText

TEXT = """\
labrun: 1
name: patient
params: {sample: {type: string, default: core}}
devices: {gantry: gantry@1}
steps: [{do: gantry.home, timeout: 1 min}]
"""
LONG = TEXT.replace("steps: [", "steps: [" + "{do: gantry.home, timeout: 1 min}, " * 5000)


@pytest.mark.slow
def test_a_text_that_takes_too_long_is_given_up_and_holds_up_nobody(tmp_path):
    async def asked():
        worker = Worker()
        patient, hasty = (
            TextCheck(worker, tmp_path, None, tmp_path / "timings.json", timeout_s=seconds)
            for seconds in (60.0, 0.1)
        )
        try:
            await patient.check(CheckText(text=TEXT))  # its process is up
            long = asyncio.create_task(hasty.check(CheckText(text=LONG)))
            turns = 0
            while not long.done():
                await asyncio.sleep(0.01)
                turns += 1
            return long.exception(), turns, await patient.check(CheckText(text=TEXT))
        finally:
            await worker.close()

    refusal, turns, after = asyncio.run(asked())

    assert isinstance(refusal, Refusal) and refusal.fault.code == "TOO_LONG"
    assert turns > 1
    assert after.ok
