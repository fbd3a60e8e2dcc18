"""P = [A1, ..., AT], interpreted without engine, wire, journal or crash: the outcome of a run.

Written from DESIGN section 3 alone. It says how the run ends, what happens for good in its main
phase (a Counter of names, and with each shot the state that every device was in), what may happen
beside it (`maybe`: what a set's failure, a race or a timeout cuts off; `either`: of these one at
least), and which rows are collected.
"""

from collections import Counter, defaultdict

from crashes_oracle_acts import Failed, Frame
from crashes_oracle_blocks import Blocks
from crashes_walk import devices


class Oracle(Blocks):
    """Interprets one protocol; `answers` are a person's answers to the question of each step."""

    def run(self, protocol):
        """The exit status of the run."""
        status = self._phase(protocol["steps"])
        main = self.happened, self.focus
        self.happened, self.focus = Counter(), defaultdict(list)
        final = self._phase(protocol.get("finally", []), self.every)
        self.happened, self.focus = main
        return max(status, final)

    def _phase(self, steps, go_through=None):
        frame = Frame()
        try:
            (go_through or self.steps)(steps, frame)
            self.join(frame)
        except Failed:
            return 1
        return 0

    def steps(self, steps, frame):
        """One after the other; the result of the last."""
        result = None
        for step in steps:
            result = self.step(step, frame)
        return result

    def every(self, steps, frame):
        """Steps of a `finally`: each of them, whatever became of those before it."""
        failures = []
        for step in steps:
            try:
                self.step(step, frame)
            except Failed as failure:
                failures.append(failure)
                if failure.stop:
                    break
        if failures:
            raise max(failures, key=lambda failure: (failure.stop, not failure.skip))

    def step(self, step, frame):
        """One step with everything around it; its result."""
        if "when" in step and not frame.holds(step["when"]):
            return None
        if step.get("mode") == "background":
            frame.aside.append(self._aside(step, frame))
            return None
        try:
            result = self._timed(step, frame)
        except Failed as failure:
            frame.results[step.get("id")] = None
            swallowed = step.get("on_error") == "continue" and not (failure.skip or failure.stop)
            if swallowed or (failure.skip and not frame.inside):
                return None
            raise
        frame.results[step.get("id")] = result
        return result

    def _timed(self, step, frame):
        """Steps that are drawn with a timeout never end in time."""
        if "timeout" not in step:
            return self._fallback(step, frame)
        self._fallback(step, frame.but(cut=frame.cut | frame.devices(devices([step]))))
        raise Failed("Timeout")

    def _aside(self, step, frame):
        there = frame.but(beside=frozenset("ab"))  # the steps that follow set what they like
        try:
            self.step({k: v for k, v in step.items() if k != "mode"}, there)
        except Failed as failure:
            return failure
        return None

    def join(self, frame):
        """Wait for what was begun aside here."""
        for failure in frame.aside:
            if failure is not None:
                raise failure

    # --- the ladder

    def _fallback(self, step, frame):
        for turn in range(100):
            there = frame.but(turns=frame.turns + turn)
            try:
                return self._retry(step, there)
            except Failed as failure:
                if "fallback" not in step or failure.skip or failure.stop:
                    raise
                choice, result = self._alternatives(step["fallback"], there, failure)
            if choice != "repeat":
                return result
        raise AssertionError("a person repeats for ever")

    def _alternatives(self, alternatives, frame, failure):
        for alternative in alternatives:
            if isinstance(alternative, dict) and "ask" in alternative:
                choice = self.answers[alternative["id"]]
                if choice != "repeat":
                    skip = choice == "skip"
                    raise Failed(failure.name, skip=skip, stop=not skip)
                return choice, None
            try:
                if isinstance(alternative, list):
                    return "", self.steps(alternative, frame)
                return "", self.step(alternative, frame)
            except Failed as again:
                if again.skip or again.stop:
                    raise
                failure = again
        raise failure

    def _retry(self, step, frame):
        rules = step.get("retry")
        if rules is None or "parallel" in step or "any" in step:
            return self._kind(step, frame)
        rules = rules if isinstance(rules, dict) else {"attempts": rules}
        attempt = 0
        for turn in range(1, rules["attempts"] + 1):
            try:
                if "do" in step:
                    attempt, result = self.act(step, frame, attempt + 1)
                    return result
                return self._kind(step, frame.but(turns=frame.turns + turn - 1))
            except Failed as failure:
                attempt = getattr(failure, "attempt", attempt)
                if turn == rules["attempts"] or not self.may_again(failure, rules.get("on")):
                    raise
        raise AssertionError("a retry has one attempt at least")

    def may_again(self, failure, on):
        """Whether a retry tries again after this failure."""
        if failure.skip or failure.stop:
            return False
        named = on is not None and failure.name in on
        return named if failure.happened else on is None or named

    # --- kinds

    def _kind(self, step, frame):
        kinds = ("do", "parallel", "any", "foreach", "repeat", "while", "if", "use", "steps",
                 "set", "fail")  # fmt: skip
        kind = next((kind for kind in kinds if kind in step), None)
        if kind is not None:
            return getattr(self, f"_{kind}")(step, frame)
        return {"choice": "yes"} if "confirm" in step else None

    def _do(self, step, frame):
        return self.act(step, frame, 1)[1]

    def _set(self, step, frame):
        new = {n: frame.values[n] + 1 if isinstance(raw, str) else raw
               for n, raw in step["set"].items()}  # fmt: skip
        frame.values |= new

    def _fail(self, step, frame):
        raise Failed("Failed")
