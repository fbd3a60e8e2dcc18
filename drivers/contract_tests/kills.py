"""What is known about an action whose server was killed halfway through."""

import asyncio
from pathlib import Path

from .served_driver import Stage, blocking


class Kills(Stage):
    """kill -9, and what ledger, probe and device report afterwards."""

    @blocking
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
        assert self.is_safe(status), f"its server was killed and is back, but it reports {status}"
        assert after.state == "SUCCEEDED", f"after the kill: {after.error}"

    @blocking
    async def test_after_a_kill_before_a_once_action_its_probe_says_what_is_true(
        self, tmp_path: Path, action: str
    ) -> None:
        await self._probe_after_kill(tmp_path, action, wait=False)

    @blocking
    async def test_after_a_kill_behind_a_once_action_its_probe_says_what_is_true(
        self, tmp_path: Path, action: str
    ) -> None:
        await self._probe_after_kill(tmp_path, action, wait=True)

    @blocking
    async def test_a_probe_of_a_once_action_that_may_still_go_on_waits_or_does_not_know(
        self, tmp_path: Path, action: str
    ) -> None:
        async with self._killed(tmp_path, action, wait=False) as (session, goal):
            probe = session.contract.actions[action].probe or ""
            answer = (await session.do(probe)).result or {}
            await asyncio.to_thread(self.rest, tmp_path)
            happened = self.happened(tmp_path, goal.id)

        if answer.get("goal_id") is not None:
            assert (answer["goal_id"] == goal.id) == happened, (
                f"asked at once after the kill, {probe} said {answer}, but in the end it {happened=}: "
                "it must wait while the instrument is busy, or report null"
            )

    async def _probe_after_kill(self, folder: Path, action: str, *, wait: bool) -> None:
        async with self._killed(folder, action, wait=wait) as (session, goal):
            await asyncio.to_thread(self.rest, folder)
            happened = self.happened(folder, goal.id)
            probe = session.contract.actions[action].probe or ""
            answer = (await session.do(probe)).result or {}

        assert happened or not wait, (
            f"{action} never happened: `happened` must agree with what the peer saw"
        )
        if answer.get("goal_id") is not None:  # null: the device reports that it does not know
            assert (answer["goal_id"] == goal.id) == happened, f"it {happened=}; {probe}: {answer}"
