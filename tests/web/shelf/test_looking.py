"""A text that cannot be looked at in time is given up, and what is asked next finds a fresh process."""

import asyncio

from labrun.web.guard.refusal import Refusal
from labrun.web.models.protocols import CheckText
from labrun.web.shelf import looking
from labrun.web.workers import Worker

TEXT = """\
labrun: 1
name: patient
params: {sample: {type: string, default: core}}
devices: {gantry: gantry@1}
steps: [{do: gantry.home, timeout: 1 min}]
"""
FOR_EVER = TEXT.replace("default: core", f"pattern: '(a+)+$', default: '{'a' * 50}!'")


def test_a_pattern_that_takes_for_ever_is_given_up_and_holds_up_nobody(tmp_path, monkeypatch):
    async def asked():
        worker = Worker()
        eyes = looking.Looking(worker, tmp_path, None, tmp_path / "timings.json")
        try:
            await eyes.check(CheckText(text=TEXT))  # its process is up
            monkeypatch.setattr(looking, "LONGEST_S", 1.0)
            endless = asyncio.create_task(eyes.check(CheckText(text=FOR_EVER)))
            turns = 0
            while not endless.done():
                await asyncio.sleep(0.01)
                turns += 1
            monkeypatch.undo()
            return endless.exception(), turns, await eyes.check(CheckText(text=TEXT))
        finally:
            await worker.close()

    refusal, turns, after = asyncio.run(asked())

    assert isinstance(refusal, Refusal) and refusal.fault.code == "TOO_LONG"
    assert turns > 10
    assert after.ok
