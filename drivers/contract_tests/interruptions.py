"""What a driver does when its action is interrupted, or when the engine is gone."""

import asyncio
from pathlib import Path
from typing import Any

from .served_driver import Stage, blocking
from .session import MOMENT_S, Session, check_status, connected

SOON_S = 3.0
"""Beside the contract's own time for a cancel."""
SHORT_LEASE_S = 0.5


class Interruptions(Stage):
    """Cancel, deadline, stop, and an engine that is gone."""

    @blocking
    async def test_a_cancellable_action_ends_when_it_is_cancelled(
        self, tmp_path: Path, action: str
    ) -> None:
        async with self._session(tmp_path, slow=True) as (session, calls):
            await session.prepare(action)
            goal, following = await session.begin(action)
            await session.client.cancel(goal.id)
            outcome = await soon(session, following, f"{action} was cancelled")
            _, again = await session.begin(action)
            await session.client.stop(self.case.device)
            await soon(session, again, f"{action} was stopped")

        assert outcome.state == "CANCELED", f"{action} was cancelled and ended {outcome}"
        assert calls.count(action) == 2 + self.case.needs.get(action, []).count(action)

    @blocking
    async def test_past_its_deadline_a_goal_is_cancelled_or_goes_on_to_its_end(
        self, tmp_path: Path
    ) -> None:
        """The server cancels it; an action that cannot be cancelled holds its device."""
        lasting = self.case.lasting
        async with self._session(tmp_path, slow=True) as (session, _):
            await session.prepare(lasting)
            _, following = await session.begin(lasting, timeout_s=2 * MOMENT_S)
            outcome = await following

        if session.contract.actions[lasting].cancel:
            assert outcome.error is not None and outcome.error.name == "Timeout", (
                f"{lasting} was cancelled and ended {outcome}"
            )
        else:
            assert outcome.state == "SUCCEEDED", (
                f"{lasting} should have continued, but ended {outcome}"
            )

    @blocking
    async def test_a_stop_ends_what_runs_and_leaves_the_device_safe(self, tmp_path: Path) -> None:
        lasting, device = self.case.lasting, self.case.device
        async with self._session(tmp_path, slow=True) as (session, _):
            await session.prepare(lasting)
            _, following = await session.begin(lasting)
            safe, words = (await session.client.stop(device))[device]
            ended = await soon(session, following, f"{device} was stopped")
            status = await session.status_once(self.is_safe)

        assert safe, words
        assert ended.state in ("CANCELED", "ABORTED", "SUCCEEDED")
        assert ended.error is None or ended.error.name != "Fault", f"after a stop: {ended.error}"
        assert self.is_safe(status), f"it was stopped, but reports {status}"
        check_status(session, status)

    @blocking
    async def test_when_its_engine_is_gone_it_does_what_the_contract_says(
        self, tmp_path: Path
    ) -> None:
        lasting = self.case.lasting
        async with self._served(tmp_path, slow=True) as (url, _):
            contract = self.case.read_contract()
            async with connected(self.case, contract, url) as gone:
                await gone.prepare(lasting)
                goal, following = await gone.begin(lasting)
                await gone.renew_for(
                    SHORT_LEASE_S
                )  # not before: a busy machine would be late to begin
            await following
            async with connected(self.case, contract, url, owner=None) as session:
                outcome = await session.client.follow(goal, send=False)
                status = await session.status_once(self.is_safe)

        match contract.on_lease_lapse:
            case "finish":
                assert outcome.state == "SUCCEEDED", f"it should have finished, but ended {outcome}"
            case "cancel" if contract.actions[lasting].cancel:
                assert outcome.state == "CANCELED", (
                    f"it should have been cancelled, but ended {outcome}"
                )
            case "safe":
                assert outcome.state != "SUCCEEDED", f"it should have been aborted: {outcome}"
        assert self.is_safe(status), f"its engine is gone, but it reports {status}"


async def soon(session: Session, following: "asyncio.Task[Any]", what: str) -> Any:
    limit_s = session.contract.cancel_grace_s + SOON_S
    done, _ = await asyncio.wait({following}, timeout=limit_s)
    assert done, f"{what}, and {limit_s:g} s later it has not ended"
    return following.result()
