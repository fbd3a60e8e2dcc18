"""What failed in a run and how it was handled, read from the journal record by record.

Only open incidents are kept one by one; an incident joins its group when its iteration ends.
"""

from dataclasses import dataclass, field

from ...engine.journal.course import Course, Goal, split_goal_id
from ...schemas import journal as j
from .goal import failed_goal, goal_in_flight, lost_goal
from .incident import Groups, Incident

PROBE = "/probe"
UNKNOWN = "/unknown"


@dataclass(slots=True)
class Outcomes:
    """Follows every goal that did not simply succeed, and records what happened next."""

    course: Course
    failures: Groups = field(default_factory=Groups)
    doubts: Groups = field(default_factory=Groups)
    latest: dict[str, Incident] = field(default_factory=dict)
    fallbacks: dict[str, Incident] = field(default_factory=dict)
    in_flight: dict[str, Incident] = field(default_factory=dict)
    last_work: dict[str, int] = field(default_factory=dict)

    # --- goals

    def sent(self, record: j.GoalSent) -> None:
        """A goal is sent: perhaps in place of one that failed, perhaps to ask what became of it."""
        path, attempt = split_goal_id(record.id)
        self._worked(path, record.n)
        if path.endswith(PROBE):
            self._doubted(path.removesuffix(PROBE))
        elif attempt > 1:
            self._given_up(f"{path}/{attempt - 1}", record)

    def ended(self, record: j.GoalEnded) -> None:
        """Record a goal's end, if the journal has the sending of it."""
        goal = self.course.under_way.get(record.id)
        if goal is None:
            return
        if goal.path.endswith(PROBE):
            self._probed(goal, record)
            return
        self._settled(goal, record)
        if record.state == "SUCCEEDED":
            self._succeeded(goal)
        else:
            self._failed(goal, record)

    def _succeeded(self, goal: Goal) -> None:
        incident = self.latest.pop(goal.path, None)
        if incident is not None:
            incident.say(f"{self._again(goal, incident)}, which succeeded")
            self._close(incident)

    def _failed(self, goal: Goal, record: j.GoalEnded) -> None:
        incident = failed_goal(goal, record, self.course.session)
        before = self.latest.get(goal.path)
        if before is not None:
            before.say(f"{self._again(goal, before)}, which failed too")
            self._close(before)
        self.latest[goal.path] = incident
        aborted_by = self.course.aborted_by
        if record.state == "CANCELED" and aborted_by:
            incident.say(f"cancelled because the run was aborted by {aborted_by}")

    def _again(self, goal: Goal, before: Incident) -> str:
        resumed = " after the run was resumed" if goal.session > before.life else ""
        return f"sent again{resumed} as attempt {goal.attempt}"

    # --- outcomes that were unknown

    def _settled(self, goal: Goal, record: j.GoalEnded) -> None:
        """A goal that was under way when an engine ended: its server has reported what became of it."""
        doubt = self.in_flight.pop(record.id, None)
        if doubt is None:
            return
        told = record.error
        if record.state == "SUCCEEDED":
            doubt.say("after the resume its server reported that it had succeeded")
        elif told is not None and told.name == "Lost":
            doubt.say(
                f"after the resume its server reported that it was lost: {_happened(told.happened)}"
            )
        else:
            name = told.name if told is not None else record.state
            doubt.say(f"after the resume its server reported that it had ended: {name}")
        self.doubts.add(doubt)

    def _given_up(self, goal_path: str, record: j.Record) -> None:
        """The engine continued without this goal's end: its server remained unreachable."""
        run_id = next((i for i in self.course.under_way if i.partition("/")[2] == goal_path), None)
        if run_id is None:
            return
        goal = self.course.under_way.pop(run_id)
        self.in_flight.pop(run_id, None)
        incident = lost_goal(goal, record)
        before = self.latest.get(goal.path)
        if before is not None:
            self._close(before)
        self.latest[goal.path] = incident

    def _doubted(self, goal_path: str) -> Incident | None:
        """The incident whose outcome is being probed."""
        self._given_up(goal_path, j.Record())
        path, _, attempt = goal_path.rpartition("/")
        incident = self.latest.get(path)
        if incident is None or str(incident.attempt) != attempt:
            return None
        incident.doubt = incident.doubt or "it was unknown whether it had happened"
        return incident

    def _probed(self, goal: Goal, record: j.GoalEnded) -> None:
        asked = goal.path.removesuffix(PROBE)
        incident = self._doubted(asked)
        if incident is None:
            return
        probe = f"the probe {goal.record.action}"
        told = record.result or {}
        if record.state != "SUCCEEDED":
            name = record.error.name if record.error else record.state
            incident.say(f"{probe} failed ({name})")
        elif told.get("goal_id") is None:
            incident.say(f"{probe} could not determine it")
        elif str(told["goal_id"]).partition("/")[2] == asked:
            incident.say(
                f"{probe} reported that it had happened; its result was taken from the probe"
            )
            self.latest.pop(incident.path, None)
            self._close(incident)
        else:
            incident.say(f"{probe} reported that it had not happened")

    # --- the ladder

    def turned(self, record: j.Turned) -> None:
        """A retried group, a fallback or a question's `repeat` begins."""
        self._worked(record.path, record.n)
        base, _, rung = record.path.rpartition("/")
        if rung == "a":
            for prefix, incident in list(self.fallbacks.items()):
                if prefix.startswith(f"{base}/"):
                    incident.say("repeated from its beginning, as the operator chose")
            return
        step = str((record.error or {}).get("step", ""))
        found = self.latest.get(step)
        stood_in = [
            held for prefix, held in self.fallbacks.items() if prefix.startswith(f"{base}/f")
        ]
        for incident in [*stood_in, *([found] if found is not None else [])]:
            if rung == "r":
                incident.say(f"the group around it was restarted, turn {record.turn}")
            else:
                incident.say(f"fallback {record.turn} was tried")
        if rung == "f" and (found is not None or stood_in):
            # What happens inside the fallback is reported for the step that it replaces.
            self.fallbacks[f"{base}/f{record.turn}/"] = stood_in[0] if stood_in else found  # type: ignore[assignment]

    def asked(self, record: j.Asked) -> None:
        """The operator is asked about it."""
        incident = self._asked_about(record.path)
        if incident is not None:
            incident.say("the operator was asked")

    def answered(self, record: j.Answered) -> None:
        """The operator has answered."""
        incident = self._asked_about(record.path)
        if incident is not None:
            incident.say(f"{record.by} answered {record.choice!r}")

    def _asked_about(self, path: str) -> Incident | None:
        if path.endswith(UNKNOWN):
            return self._doubted(path.removesuffix(UNKNOWN))
        fitting = [prefix for prefix in self.fallbacks if path.startswith(prefix)]
        return self.fallbacks[max(fitting, key=len)] if fitting else None

    # --- ends

    def iteration(self, record: j.IterationEnded, *, is_over: bool = False) -> None:
        """An iteration has ended, and with it every incident inside; `is_over`: it was done again since."""
        self._worked(record.loop, record.n)
        prefix = f"{record.loop}/{record.key}/"
        for goal_id in [
            i for i, goal in self.course.under_way.items() if goal.path.startswith(prefix)
        ]:
            self._given_up(goal_id.partition("/")[2], record)
        hole = "a hole, which was measured again" if is_over else "a hole"
        handled = {id(incident) for incident in self.fallbacks.values()}
        for path in [path for path in self.latest if path.startswith(prefix)]:
            incident = self.latest.pop(path)
            blamed = f"{path}:" in record.message or id(incident) in handled
            if record.fate == "succeeded":
                incident.say("the iteration continued and succeeded")
            elif blamed:
                incident.say(f"the iteration was left out: {hole}")
            else:
                incident.say(
                    f"the iteration continued, and was left out for another reason: {hole}"
                )
            self._close(incident)
        for key in [key for key in self.fallbacks if key.startswith(prefix)]:
            del self.fallbacks[key]

    def engine_gone(self) -> None:
        """The engine ended before the goals under way did; another one takes over."""
        for goal_id, goal in self.course.under_way.items():
            if goal_id not in self.in_flight and not goal.path.endswith(PROBE):
                self.in_flight[goal_id] = goal_in_flight(goal)

    def run_ended(self, record: j.Finished) -> None:
        """The details of the run's end name the step that failed; before there were any, its reason did."""
        for path, incident in self.latest.items():
            if f"{path}:" in (record.detail or record.reason):
                incident.say(f"the run {record.fate} because of it")

    def close(self, *, live: bool) -> None:
        """End of the journal: incidents that are still open remain open."""
        finished = self.course.finished is not None
        for goal in list(self.course.under_way.values()):
            if goal.path.endswith(PROBE):
                continue
            doubt = self.in_flight.pop(goal.record.id, None) or goal_in_flight(goal)
            if live:
                continue
            if finished:
                doubt.doubt = (
                    "its server remained unreachable, and the run ended without its outcome"
                )
            doubt.say("not resolved; `labrun resume` asks its server")
            self.doubts.add(doubt)
        for incident in self.latest.values():
            incident.followed += self._left_at(incident, finished=finished)
            self._close(incident)
        self.course.under_way.clear()
        self.latest.clear()

    def _left_at(self, incident: Incident, *, finished: bool) -> list[str]:
        if any(said.startswith("the run ") for said in incident.followed):
            return []
        if incident.n < self.last_work.get(_phase(incident.path), 0):
            return ["the run continued"]
        return [] if finished else ["the run stopped here: nothing has followed yet"]

    def _worked(self, path: str, n: int) -> None:
        self.last_work[_phase(path)] = n

    def _close(self, incident: Incident) -> None:
        self.failures.add(incident)
        if incident.doubt:
            self.doubts.add(incident)


def _phase(path: str) -> str:
    return path.partition("/")[0]


def _happened(word: str) -> str:
    return {"no": "it had not happened", "yes": "it had happened"}.get(
        word, "it is unknown whether it had happened"
    )
