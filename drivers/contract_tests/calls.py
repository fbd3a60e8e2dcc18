"""How a driver handles calls: valid or invalid, once or repeated."""

from pathlib import Path

from ...schemas.contract import Contract
from ..find import check_driver, find_driver
from ..server.arguments import read_limits
from .bad_calls import bad_calls
from .served_driver import Stage, blocking
from .session import check_status


class Calls(Stage):
    """Describe, valid calls, invalid calls, busy, the same goal again, status."""

    def test_the_driver_has_what_its_contract_wants_and_each_action_a_good_call(self) -> None:
        contract = self.case.read_contract()
        if self.case.driver:
            check_driver(find_driver(self.case.driver, Path()), contract)

        assert set(self.case.good) == set(contract.actions), "`good` has one call of each action"
        assert self.case.lasting in contract.actions, f"there is no action {self.case.lasting}"

    @blocking
    async def test_it_describes_itself_as_its_contract_says(self, tmp_path: Path) -> None:
        async with self._session(tmp_path) as (session, _):
            said = session.client.devices[self.case.device]

        assert Contract.model_validate(said.contract) == session.contract, "another one is served"
        assert set(said.limits) == set(self.case.limits), f"limits: {said.limits}"
        check_status(session, said.status)

    @blocking
    async def test_a_good_call_succeeds(self, tmp_path: Path, action: str) -> None:
        async with self._session(tmp_path) as (session, calls):
            await session.prepare(action)
            outcome = await session.do(action)
            status = await session.newest_status()

        assert outcome.state == "SUCCEEDED", f"{action}: {outcome.error}"
        wanted = 1 + self.case.needs.get(action, []).count(action)
        assert calls.count(action) == wanted, f"{action}: the driver was called {calls}"
        check_status(session, status)

    @blocking
    async def test_a_bad_call_is_refused_with_a_sentence(self, tmp_path: Path) -> None:
        async with self._session(tmp_path) as (session, calls):
            limits = read_limits(self.case.limits, session.contract)
            tried = [
                (action, what, params)
                for action, wanted in session.contract.actions.items()
                for what, params in [
                    *bad_calls(wanted, self.case.good[action], limits),
                    *(("bad", params) for params in self.case.bad.get(action, [])),
                ]
            ]
            endings = [(a, what, await session.do(a, params)) for a, what, params in tried]

        for action, what, outcome in endings:
            error = outcome.error
            assert error is not None and error.name == "Rejected", f"{action}, {what}: {outcome}"
            assert error.happened == "no" and action in error.message, f"{action}, {what}: {error}"
        assert calls == [], "a refused call must never reach the driver"

    @blocking
    async def test_a_second_goal_is_refused_as_busy_unless_it_is_concurrent(
        self, tmp_path: Path
    ) -> None:
        lasting = self.case.lasting
        async with self._session(tmp_path, slow=True) as (session, calls):
            await session.prepare(lasting)
            await session.begin(lasting)
            if session.contract.concurrent:
                _, second = await session.begin(lasting)
                state = (await second).state
            else:
                refused = (await session.do(lasting)).error
                state = refused.name if refused is not None else "accepted"

        wanted = ("SUCCEEDED", 2) if session.contract.concurrent else ("Busy", 1)
        assert (state, calls.count(lasting)) == wanted, f"{lasting}, twice at a time: {state}"

    @blocking
    async def test_the_same_goal_again_is_answered_and_not_done(self, tmp_path: Path) -> None:
        lasting = self.case.lasting
        async with self._session(tmp_path) as (session, calls):
            await session.prepare(lasting)
            goal = session.goal(lasting)
            first = await session.client.follow(goal)
            again = await session.client.follow(goal)

        said = [(one.state, one.result, one.files) for one in (first, again)]
        assert said[0] == said[1], f"the same goal, twice: {first}, {again}"
        assert calls.count(lasting) == 1, f"the same goal was done {calls.count(lasting)} times"

    @blocking
    async def test_its_status_keeps_its_schema_while_something_is_done(
        self, tmp_path: Path
    ) -> None:
        async with self._session(tmp_path, slow=True) as (session, _):
            await session.prepare(self.case.lasting)
            await session.begin(self.case.lasting)
            status = await session.newest_status()

        check_status(session, status)
