"""`/move_gantry`, an action and a service: lines of G-code in, moves of a gantry out."""

from ..offers.goals import Goals
from ..offers.offer import End, Refused, Service, Values, Work
from .gcode import GcodeFault, UnknownPosition, steps
from .kinds import MOVE_GANTRY, MOVE_GANTRY_CALL
from .paper import AXES, Paper, PaperAction


class MoveGantry(PaperAction):
    """Every line is checked before the first is sent; positions count from the zero of `/set_zero`."""

    kind = MOVE_GANTRY
    said = "msg"
    can_cancel = True

    @classmethod
    def add(cls, paper: Paper, name: str, device: str) -> None:
        """Offer it as both."""
        move = paper.offered.offers.actions[name] = cls(paper, name, device)
        paper.offered.offers.services[name] = MoveGantryCall(move, paper.offered.goals)

    async def carry(self, work: Work) -> End:
        """One move after the other, until one fails."""
        zero, cmd = self.paper.zero(self.device), str(work.values.get("cmd", ""))
        try:
            try:
                program = steps(cmd, {})
            except UnknownPosition:  # it begins relative to where the gantry is
                status = await self.paper.status_from_now(self.device)
                known = [axis for axis in AXES if status.get(axis) is not None]
                program = steps(cmd, {axis: status[axis] - zero[axis] for axis in known})
        except GcodeFault as fault:
            raise Refused(f"cmd: {fault}") from fault
        parts = []
        for step in program:
            action = self.paper.action(self.device, "home" if step.verb == "home" else "move_to")
            params = {axis: place + zero[axis] for axis, place in step.place_mm.items()}
            if step.feed_mm_min is not None:
                params["feed"] = step.feed_mm_min
            parts.append((action, action.checked(params)))
        end = End("SUCCEEDED", {})
        for number, (action, params) in enumerate(parts, 1):
            if work.cancelled.is_set():
                return self.ended(work, End("CANCELED", {"error_name": "Canceled"}))
            end = await self.done(action, params, work, number)
            if end.state != "SUCCEEDED":
                break
        return self.ended(work, end)


class MoveGantryCall(Service):
    """The same as a service; unlike the paper's, it answers when the moves have ended."""

    kind = MOVE_GANTRY_CALL

    def __init__(self, move: MoveGantry, goals: Goals) -> None:
        self.name = move.name
        self._move = move
        self._goals = goals

    async def answer(self, values: Values) -> Values:
        """`{response}`: `succeed`, or what went wrong; raises Refused."""
        goal = await self._goals.begin(self._move, values, lambda feedback: None)
        end = await goal.end()
        return {"response": "succeed" if end.state == "SUCCEEDED" else end.result["msg"]}
