"""What all optimizers have in common: a log of studies, and a method that looks at one of them.

What a method suggests follows from what is in the log and from nothing else, so that a server that
was killed goes on where it was.
"""

import asyncio
from typing import Any, ClassVar

from ..driver import ActionFailed, Driver, GoalContext, Place, check_keys
from .best import best_of
from .problem import Point, Problem, WrongProblem, read_problem
from .study import Study, StudyLog, Values

Prediction = dict[str, list[float]]


class Exhausted(Exception):
    """Nothing is left that could be suggested."""


class TooFew(Exception):
    """Too little has been told for a model; the text says how much there must be."""


class Optimizer(Driver):
    """Implements optimizer@1 but for `suggest` and, if the method has a model, `predict`.

    Configuration: none; the protocol says everything.
    """

    contract: ClassVar[str] = "optimizer@1"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        check_keys((), place.config)
        self._log: StudyLog
        self._study: Study | None = None
        self._lock = asyncio.Lock()

    def suggest(self, study: Study, n: int) -> list[Point]:
        """Up to n points to try next; raises Exhausted and WrongProblem. In a thread."""
        raise NotImplementedError

    def predict(self, study: Study, at: list[Point]) -> tuple[Prediction, Prediction]:
        """Mean and standard deviation of each goal at each place; raises TooFew. In a thread."""
        raise ActionFailed("NoModel", f"{type(self).__name__} has no model of what lies between")

    async def open(self) -> None:
        self._log = StudyLog(self.place.folder / "studies.sqlite")
        if newest := self._log.newest("define"):
            self._study = self._read(newest[1])

    async def close(self) -> None:
        self._log.close()

    async def status(self) -> dict[str, Any]:
        study = self._study
        if study is None:
            return {"study": None, "told": 0, "waiting": 0}
        return {"study": study.name, "told": study.told, "waiting": len(study.waiting)}

    async def define(self, goal: GoalContext, **said: Any) -> dict[str, Any]:
        run = goal.id.partition("/")[0]
        name = said.pop("study", "") or run
        try:
            problem = await asyncio.to_thread(read_problem, said)
            earlier = self._read(name)
        except WrongProblem as fault:
            raise ActionFailed("WrongStudy", str(fault)) from fault
        if earlier is not None:
            _check_same(earlier, problem)
        self._log.add(goal.id, name, "define", said)
        self._study = self._read(name)
        assert self._study is not None
        return {"study": name, "told": self._study.told, "places": problem.size}

    async def ask(self, goal: GoalContext, *, n: int = 1) -> dict[str, Any]:
        study = self._of(goal)
        async with self._lock:
            if (known := self._log.of_goal(goal.id)) is not None:
                return {"suggestions": known}
            try:
                points = await asyncio.to_thread(self.suggest, study, n)
            except Exhausted as fault:
                raise ActionFailed("Exhausted", str(fault)) from fault
            except WrongProblem as fault:
                raise ActionFailed("WrongStudy", str(fault)) from fault
            self._log.add(goal.id, study.name, "ask", points)
            study.suggested(points)
        return {"suggestions": points}

    async def last_ask(self, goal: GoalContext) -> dict[str, Any]:
        newest = self._log.newest("ask")  # empty: a memory that outlives a kill does know
        return {"goal_id": newest[0], "suggestions": newest[2]} if newest else {"goal_id": ""}

    async def tell(self, goal: GoalContext, *, at: Point, values: Values) -> dict[str, Any]:
        study = self._of(goal)
        _check_point(study.problem, at)
        _check_values(study.problem, values)
        async with self._lock:
            if self._log.of_goal(goal.id) is None:
                line = {"at": at, "values": values, "told": study.told + 1}
                self._log.add(goal.id, study.name, "tell", line)
                study.tell(at, values)
        return {"told": study.told}

    async def last_tell(self, goal: GoalContext) -> dict[str, Any]:
        newest = self._log.newest("tell")
        return {"goal_id": newest[0], "told": newest[2]["told"]} if newest else {"goal_id": ""}

    async def best(self, goal: GoalContext) -> dict[str, Any]:
        study = self._of(goal)
        if study.problem.maps:
            raise ActionFailed(
                "NoBest", "the goals are maps, which have no best place; ask `model`"
            )
        if not study.at:
            raise ActionFailed("NoData", f"nothing has been told of {study.name} yet")
        return best_of(study)

    async def model(self, goal: GoalContext, *, at: list[Point]) -> dict[str, Any]:
        study = self._of(goal)
        for point in at:
            _check_point(study.problem, point)
        try:
            mean, deviation = await asyncio.to_thread(self.predict, study, at)
        except TooFew as fault:
            raise ActionFailed("NoData", str(fault)) from fault
        return {"mean": mean, "deviation": deviation}

    def _of(self, goal: GoalContext) -> Study:
        """The study that this run has defined; for others the newest."""
        newest = self._log.newest("define", goal.id.partition("/")[0])
        newest = newest or self._log.newest("define")
        if newest is None:
            raise ActionFailed("NotDefined", "nothing is defined yet: `define` says what is wanted")
        if self._study is None or self._study.name != newest[1]:
            self._study = self._read(newest[1])
        assert self._study is not None
        return self._study

    def _read(self, name: str) -> Study | None:
        """A study from its log; None if there is none of that name."""
        study: Study | None = None
        for what, said in self._log.of_study(name):
            if what == "define":
                problem = read_problem(said)
                study = study or Study(name, problem)
                study.problem = problem
            elif study is not None and what == "ask":
                study.suggested(said)
            elif study is not None:
                study.tell(said["at"], said["values"])
        return study


def _check_same(earlier: Study, problem: Problem) -> None:
    before = {v.name: bool(v.choices) for v in earlier.problem.variables}
    now = {v.name: bool(v.choices) for v in problem.variables}
    if before != now or dict(earlier.problem.goals) != dict(problem.goals):
        raise ActionFailed(
            "WrongStudy",
            f"the study {earlier.name} varies {', '.join(before)} and wants "
            f"{_wanted(earlier.problem)}; give this one another name",
        )


def _wanted(problem: Problem) -> str:
    return ", ".join(f"{name}: {wanted}" for name, wanted in problem.goals.items())


def _check_point(problem: Problem, at: Point) -> None:
    names = [variable.name for variable in problem.variables]
    if set(at) != set(names):
        raise ActionFailed("WrongNames", f"{', '.join(at)} is told; asked was {', '.join(names)}")
    for variable in problem.variables:
        value = at[variable.name]
        if variable.choices and value not in variable.choices:
            known = ", ".join(str(one) for one in variable.choices)
            raise ActionFailed("WrongValue", f"{variable.name} is {value}, none of {known}")
        if not variable.choices and isinstance(value, str | bool):
            raise ActionFailed("WrongValue", f"{variable.name} is {value!r}, which is no number")


def _check_values(problem: Problem, values: Values) -> None:
    if set(values) != set(problem.goals):
        told, wanted = ", ".join(values), ", ".join(problem.goals)
        raise ActionFailed("WrongNames", f"values of {told} are told; the goals are {wanted}")
