"""P = [A1, ..., AT], interpreted without engine, wire, journal or crash: what a run comes to.

Written from DESIGN section 3 alone. It says how the run ends, what happens for good in its main
phase (a Counter of names, and with each shot the state that every device was in), what may happen
beside it (`maybe`: what a set's failure cancels), and which rows are collected.
"""

import re
from collections import Counter, defaultdict
from dataclasses import dataclass, field

ANY = "any"
"""A state that nothing is said about: set beside the shot, or in an iteration that is over."""

HAPPENS = {"ok": True, "Half": True, "happened!": True, "die+": True}
NAMES = {"happened!": "Foggy", "dark": "Foggy", "die+": "Lost", "die-": "Lost"}
UNKNOWN = tuple(NAMES)


class Failed(Exception):
    """One failure on its way up; `happened` for a `once` action that took effect all the same."""

    def __init__(self, name, *, happened=False, skip=False, stop=False):
        super().__init__(name)
        self.name, self.happened, self.skip, self.stop = name, happened, skip, stop


@dataclass
class Frame:
    """Where a step stands: loop names, results, turns of the groups around it, loops entered.

    `beside`: devices that are set meanwhile; `cut`: devices whose actions may have been cancelled.
    """

    names: dict = field(default_factory=dict)
    results: dict = field(default_factory=dict)
    turns: int = 1
    inside: tuple = ()
    beside: frozenset = frozenset()
    cut: frozenset = frozenset()
    aside: list = field(default_factory=list)

    def but(self, **changed):
        return Frame(**{**self.__dict__, **changed})


class Oracle:
    """Interprets one protocol; `answers` is what a person says to the question of each step."""

    def __init__(self, answers=None):
        self.answers = answers or {}
        self.happened = Counter()
        self.maybe = Counter()
        self.focus = defaultdict(list)
        self.tables = {}
        self.holes = 0
        self.values = {}
        self.states = {}
        self.newest = {}

    def run(self, protocol):
        """The exit status of the run."""
        status = self._phase(protocol["steps"])
        main = self.happened, self.focus
        self.happened, self.focus = Counter(), defaultdict(list)
        final = self._phase(protocol.get("finally", []))
        self.happened, self.focus = main
        return max(status, final)

    def _phase(self, steps):
        frame = Frame()
        try:
            self.steps(steps, frame)
            self._join(frame)
        except Failed:
            return 1
        return 0

    def steps(self, steps, frame):
        result = None
        for step in steps:
            result = self.step(step, frame)
        return result

    # --- the ladder

    def step(self, step, frame):
        """One step with everything around it; its result."""
        if "when" in step and self.values["v"] <= 1:  # the one condition that is ever drawn
            return None
        if step.get("mode") == "background":
            frame.aside.append(self._aside(step, frame))
            return None
        try:
            result = self._fallback(step, frame)
        except Failed as failure:
            frame.results[step.get("id")] = None
            swallowed = step.get("on_error") == "continue" and not (failure.skip or failure.stop)
            if swallowed or (failure.skip and not frame.inside):
                return None
            raise
        frame.results[step.get("id")] = result
        return result

    def _aside(self, step, frame):
        there = frame.but(beside=frozenset("ab"))  # the steps that follow set what they like
        try:
            self.step({k: v for k, v in step.items() if k != "mode"}, there)
        except Failed as failure:
            return failure
        return None

    def _join(self, frame):
        for failure in frame.aside:
            if failure is not None:
                raise failure

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
        if rules is None or "parallel" in step:
            return self._kind(step, frame)
        rules = rules if isinstance(rules, dict) else {"attempts": rules}
        attempt = 0
        for turn in range(1, rules["attempts"] + 1):
            try:
                if "do" in step:
                    attempt, result = self._act(step, frame, attempt + 1)
                    return result
                return self._kind(step, frame.but(turns=frame.turns + turn - 1))
            except Failed as failure:
                attempt = getattr(failure, "attempt", attempt)
                if turn == rules["attempts"] or not self._again(failure, rules.get("on")):
                    raise
        raise AssertionError("a retry has one attempt at least")

    def _again(self, failure, on):
        if failure.skip or failure.stop:
            return False
        named = on is not None and failure.name in on
        return named if failure.happened else on is None or named

    # --- kinds

    def _kind(self, step, frame):
        for kind in ("do", "parallel", "foreach", "steps", "set", "fail"):
            if kind in step and not (kind == "steps" and "foreach" in step):
                return getattr(self, f"_{kind}")(step, frame)
        return {"choice": "yes"} if "confirm" in step else None

    def _do(self, step, frame):
        return self._act(step, frame, 1)[1]

    def _act(self, step, frame, attempt):
        """Attempts of one action until its fate is known: (the last one's number, its result)."""
        asked = {"word": "ok", "tries": 0, "turns": 0, **step["with"]}
        device, action = step["do"].split(".")
        name = re.sub(r"\$\{\{ (\w+) \}\}", lambda m: str(frame.names[m[1]]), asked["name"])
        while True:
            fails = attempt <= asked["tries"] or frame.turns <= asked["turns"]
            word = asked["word"] if fails else "ok"
            if HAPPENS.get(word):
                self._happens(device, action, name, asked.get("to"), step, frame)
            if word == "ok":
                return attempt, {"name": name}
            failure = Failed(NAMES.get(word, word), happened=word == "Half" and action == "shoot")
            failure.attempt = attempt
            verdict = ""
            if word in UNKNOWN and action == "shoot":
                verdict = self._find_out(step, device, HAPPENS.get(word))
            if verdict == "happened":
                return attempt, {"name": name}
            if verdict != "repeat":
                failure.skip, failure.stop = verdict == "skip", verdict == "stop"
                raise failure
            attempt += 1

    def _happens(self, device, action, name, to, step, frame):
        if action == "set":
            self.states[device] = (ANY, ()) if device in frame.cut else (to, frame.inside)
        if action == "shoot" and device in frame.cut:
            self.maybe[name] += 1
        elif action == "shoot":
            self.newest[device] = name
            self.happened[name] += 1
            self.focus[name].append({d: self._state(d, frame) for d in ("a", "b")})

    def _state(self, device, frame):
        value, inside = self.states.get(device, (ANY, ()))
        over = frame.inside[: len(inside)] != inside
        return ANY if over or device in frame.beside else value

    def _find_out(self, step, device, happened):
        policy = step.get("on_unknown", "probe")
        if policy == "probe" and happened:
            return "happened"
        if policy == "probe" and device in self.newest:
            return ""
        return policy if policy in ("skip", "repeat") else self.answers[step["id"]]

    def _parallel(self, step, frame):
        busy = frozenset(m["do"][0] for m in step["parallel"] if m["do"].endswith(".set"))
        failures = []
        for member in step["parallel"]:  # of a set that cancels, only the first can fail
            if failures and step.get("on_failure") == "cancel":
                frame = frame.but(cut=frozenset(member["do"][0]))
            there = frame.but(beside=frame.beside | busy - {member["do"][0]})
            for turn in range(step.get("retry", 1)):
                try:
                    self.step(member, there.but(turns=frame.turns + turn))
                    break
                except Failed as failure:
                    if turn + 1 == step.get("retry", 1) or not self._again(failure, None):
                        failures.append(failure)
                        break
        if failures:
            raise failures[0]

    def _steps(self, step, frame):
        inner = frame if frame.inside else frame.but(aside=[])
        result = self.steps(step["steps"], inner)
        if inner is not frame:
            self._join(inner)
        return result

    def _foreach(self, step, frame):
        ((item, values),) = step["foreach"].items()
        counts = Counter()
        for index, value in enumerate(values):
            fate = self._iteration(step, item, value, index, frame, counts)
            counts[fate] += 1
        return counts

    def _iteration(self, step, item, value, index, frame, counts):
        there = frame.but(
            names={**frame.names, item: value}, results=dict(frame.results), aside=[],
            inside=(*frame.inside, (step["id"], index, frame.turns)),
        )  # fmt: skip
        fate = "succeeded"
        try:
            self.steps(step["steps"], there)
            self._join(there)
        except Failed as failure:
            limit = step.get("keep_going", {}).get("max_failed", 0)
            if failure.stop or not (failure.skip or counts["failed"] + 1 <= limit):
                raise
            fate = "failed"
            self.holes += 1
        if "collect" in step:
            self._collect(step, index, fate, there)
        return fate

    def _collect(self, step, index, fate, frame):
        row = [str(index), *(self._cell(raw, frame) for raw in step["collect"].values()), fate]
        header = ",".join(["key", *step["collect"], "fate"])
        self.tables.setdefault(header, []).append(",".join(row))

    def _cell(self, raw, frame):
        names = raw.removeprefix("${{ ").removesuffix(" }}").split(".")
        if names[0] == "steps":
            result = frame.results.get(names[1])
            return result["name"] if result else ""
        return str({**self.values, **frame.names}[names[0]])

    def _set(self, step, frame):
        for name, raw in step["set"].items():
            before = self.values.get(name, 0)
            self.values[name] = before + 1 if isinstance(raw, str) else raw

    def _fail(self, step, frame):
        raise Failed("Failed")
