"""Work by path: what was done, how it ended, which way was taken."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from ...schemas import journal as j

PASS = "pass:"
"""`main/scan/4,1/pass:2/shoot`: the shot of the second pass of that point."""


@dataclass(frozen=True, slots=True)
class PastGoal:
    """A goal that was sent; `ended` is None while its fate is not in the journal.

    `state_n`: the record since which the device has the state that the goal gave it. `spent`: it
    does not count against the retries. `expired`: it took longer than its timeout.
    """

    sent: j.GoalSent
    ended: j.GoalEnded | None = None
    state_n: int = 0
    spent: bool = False
    expired: bool = False

    @property
    def succeeded(self) -> bool:
        """True if it ended well."""
        return self.ended is not None and self.ended.state == "SUCCEEDED"

    @property
    def is_unknown(self) -> bool:
        """True if it ended, and its device did not report whether it happened."""
        if self.ended is None or self.succeeded:
            return False
        error = self.ended.error
        return error is None or error.happened == "unknown"

    def was_under_way(self, n: int) -> bool:
        """True if it had been sent before record `n`, and its outcome came after it."""
        return self.sent.n < n and (self.ended is None or self.ended.n >= n)


@dataclass(slots=True)
class Past:
    """What a tree finds done when it is planted; what lies in finished iterations is forgotten.

    `begun_anew`, `spent_n`: the run had ended (failed, aborted) and is resumed since that record.
    `comparing` keeps what lies in finished iterations, so that all of it can be replayed.
    """

    comparing: bool = False
    begun_anew: bool = False
    spent_n: int = 0
    changed: j.Changed | None = None
    goals: dict[str, dict[int, PastGoal]] = field(default_factory=dict)
    iterations: dict[str, dict[str, j.StepFate]] = field(default_factory=dict)
    sets: dict[str, dict[str, Any]] = field(default_factory=dict)
    settings: dict[str, dict[tuple[str, str], PastGoal]] = field(default_factory=dict)
    """By loop: what its finished iterations have set on devices, the newest of (device, what)."""
    steps: dict[str, j.StepEnded] = field(default_factory=dict)
    computed: dict[str, Any] = field(default_factory=dict)
    """What clocks have said, as encoded, by path of the step and what asked."""
    turned: dict[str, j.Turned] = field(default_factory=dict)
    answers: dict[str, j.Answered] = field(default_factory=dict)
    passes: dict[str, int] = field(default_factory=dict)
    """Iterations and actions that are done again -> the number of their newest pass."""
    gone_through: set[str] = field(default_factory=set)
    _visited: set[str] = field(default_factory=set)

    def goal(self, path: str, attempt: int) -> PastGoal | None:
        """What is known about one attempt at one path."""
        return self.goals.get(path, {}).get(attempt)

    def newest_success(self, path: str) -> PastGoal | None:
        """The last attempt at a path that succeeded."""
        tries = reversed(self.goals.get(path, {}).values())
        return next((past for past in tries if past.succeeded), None)

    def has_begun(self, path: str) -> bool:
        """True if anything under this path was begun."""
        tables = (self.goals, self.iterations, self.steps, self.computed, self.answers)
        return any(known.startswith(f"{path}/") for table in tables for known in table)

    def knows_nothing_of(self, path: str) -> bool:
        """True if a comparison finds nothing to compare under this path."""
        if self.comparing and not self._visited:
            known = (*self.goals, *self.steps, *self.gone_through)
            self._visited = {p for path in known for p in upwards(path)}
        return self.comparing and path not in self._visited

    def is_over(self, turned: j.Turned) -> bool:
        """True if the run has ended since, and tries again what had failed."""
        return turned.n <= self.spent_n

    def is_before_change(self, turned: j.Turned) -> bool:
        """True if the protocol has changed since a branch was chosen."""
        return self.comparing or (self.changed is not None and turned.n < self.changed.n)

    def open_goals(self) -> list[PastGoal]:
        """Goals that were sent and whose outcome is not in the journal."""
        return [g for tries in self.goals.values() for g in tries.values() if g.ended is None]

    def unknown_fates(self) -> list[PastGoal]:
        """`once` goals that have ended, but may or may not have happened."""
        newest = (tries[max(tries)] for tries in self.goals.values())
        return [past for past in newest if past.sent.effect == "once" and past.is_unknown]

    def forget(self, prefix: str) -> None:
        """Drop everything under a finished iteration."""
        for table in (
            self.goals, self.iterations, self.sets, self.settings, self.steps, self.computed,
            self.turned, self.answers,
        ):  # fmt: skip
            for path in [path for path in table if path.startswith(prefix)] if table else ():
                del table[path]

    def keep_settings(self, loop: str, prefix: str) -> None:
        """An iteration of a loop is over: what it has set on devices belongs to the loop from now on."""
        done = [g for path, tries in self.goals.items() if path.startswith(prefix)
                for g in tries.values() if g.succeeded and g.sent.sets]  # fmt: skip
        for inner in [path for path in self.settings if path.startswith(prefix)]:
            done += self.settings.pop(inner).values()
        if not done:
            return
        kept = self.settings.setdefault(loop, {})
        for goal in done:
            what = goal.sent.device, goal.sent.sets
            if what not in kept or kept[what].sent.n < goal.sent.n:
                kept[what] = goal

    def forget_under_way(self, above: str, n: int) -> None:
        """Drop goals at a path that were under way at record `n`: nothing waited for them after it."""
        for path in [path for path in self.goals if f"{path}/".startswith(f"{above}/")]:
            tries = self.goals.pop(path)
            kept = {a: past for a, past in tries.items() if not past.was_under_way(n)}
            self.goals |= {path: kept} if kept else {}

    def pass_path(self, path: str) -> str:
        """The path of what is done in an iteration, or of an action: a new pass has its own level."""
        number = self.passes.get(path)
        return path if number is None else f"{path}/{PASS}{number}"

    def copy(self) -> "Past":
        """The same, for a tree that takes out of it what it has found."""
        return replace(
            self,
            goals={path: dict(tries) for path, tries in self.goals.items()},
            iterations={loop: dict(fates) for loop, fates in self.iterations.items()},
            sets={loop: dict(values) for loop, values in self.sets.items()},
            settings={loop: dict(goals) for loop, goals in self.settings.items()},
            steps=dict(self.steps),
            computed=dict(self.computed),
            turned=dict(self.turned),
            answers=dict(self.answers),
            gone_through=set(self.gone_through),
        )


def without_passes(path: str) -> str:
    """A path as the protocol has it: without the level of a later pass."""
    if PASS not in path:
        return path
    return "/".join(part for part in path.split("/") if not part.startswith(PASS))


def upwards(path: str) -> Iterator[str]:
    """This path and every path above it."""
    while path:
        yield path
        path = path.rpartition("/")[0]
