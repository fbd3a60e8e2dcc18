"""What is known of an action whose server was killed in the middle of it."""

import asyncio
from pathlib import Path

from .stage import Stage, told


class Kills(Stage):
    """kill -9, and what ledger, probe and device say afterwards."""

    @told
    async def test_after_a_kill_nobody_guesses_and_the_device_can_be_used_again(
        self, tmp_path: Path
    ) -> None:
        lasting = self.case.lasting
        async with self._killed(tmp_path, lasting) as (session, goal):
            outcome = await session.client.follow(goal, send=False)
            status = await session.status_once(self.is_safe)
            await session.prepare(lasting)
            after = await session.do(lasting)

        assert outcome.error is not None and outcome.error.name == "Lost"
        assert outcome.error.happened == "unknown"
        assert self.is_safe(status), f"its server was killed and is back, and it says {status}"
        assert after.state == "SUCCEEDED", f"after the kill: {after.error}"

    @told
    async def test_after_a_kill_before_a_once_action_its_probe_says_what_is_true(
        self, tmp_path: Path, action: str
    ) -> None:
        await self._probe_after_kill(tmp_path, action, wait=False)

    @told
    async def test_after_a_kill_behind_a_once_action_its_probe_says_what_is_true(
        self, tmp_path: Path, action: str
    ) -> None:
        await self._probe_after_kill(tmp_path, action, wait=True)

    async def _probe_after_kill(self, folder: Path, action: str, *, wait: bool) -> None:
        async with self._killed(folder, action, wait=wait) as (session, goal):
            await asyncio.to_thread(self.rest, folder)
            happened = self.happened(folder, goal.id)
            probe = session.contract.actions[action].probe or ""
            told = (await session.do(probe)).result or {}

        assert happened or not wait, (
            f"{action} never happened: `happened` is to say what the peer saw"
        )
        if told.get("goal_id") is not None:  # null: the device does not know, and says so
            assert (told["goal_id"] == goal.id) == happened, f"it {happened=}; {probe}: {told}"
