"""The outcome of one action, attempt by attempt, and the devices' states meanwhile."""

import re
from collections import Counter, defaultdict
from dataclasses import dataclass, field

ANY = "any"
"""A state about which nothing is claimed: set beside the shot."""

HAPPENS = {"ok": True, "Half": True, "happened!": True, "die+": True}
NAMES = {"happened!": "Foggy", "dark": "Foggy", "die+": "Lost", "die-": "Lost"}
UNKNOWN = tuple(NAMES)


class Failed(Exception):
    """One failure on its way up; `happened` for a `once` action that took effect anyway."""

    def __init__(self, name, *, happened=False, skip=False, stop=False):
        super().__init__(name)
        self.name, self.happened, self.skip, self.stop = name, happened, skip, stop


@dataclass
class Frame:
    """Where a step is: names and results, turns of the groups around it, loops entered.

    `names` are those of loops and parameters, `values` those that `set` gives, `roles` those of a
    used protocol; `loops` is False outside the loops of its own protocol, `inside` names also those
    of whoever uses it. `beside`: devices that
    are set meanwhile; `cut`: devices whose actions may have been cancelled.
    """

    names: dict = field(default_factory=dict)
    values: dict = field(default_factory=dict)
    results: dict = field(default_factory=dict)
    roles: dict = field(default_factory=dict)
    loops: bool = False
    turns: int = 1
    inside: tuple = ()
    keys: tuple = ()
    beside: frozenset = frozenset()
    cut: frozenset = frozenset()
    aside: list = field(default_factory=list)
    shared: bool = False

    def but(self, **changed):
        return Frame(**{**self.__dict__, **changed})

    def text(self, raw):
        """A text with the names in it replaced."""
        return re.sub(r"\$\{\{ ([\w.]+) \}\}", lambda m: str(self.names[m[1]]), raw)

    def holds(self, raw):
        """Whether a condition holds: a counter, compared with a number."""
        name, how, number = raw.removeprefix("${{ ").removesuffix(" }}").split()
        value = self.values[name]
        return value < int(number) if how == "<" else value > int(number)

    def devices(self, roles):
        """The devices that play these roles."""
        return frozenset(self.roles.get(role, role) for role in roles)


class Acts:
    """What happens for good, may happen, and is found; `answers` are a person's answers."""

    def __init__(self, answers=None):
        self.answers = answers or {}
        self.happened = Counter()
        self.maybe = Counter()
        self.either = []
        self.tidy = set()
        self.focus = defaultdict(list)
        self.tables = {}
        self.holes = 0
        self.states = {}
        self.newest = {}

    def act(self, step, frame, attempt):
        """Attempts of one action until its fate is known: (the last one's number, its result)."""
        asked = {"word": "ok", "tries": 0, "turns": 0, **step["with"]}
        role, action = step["do"].split(".")
        device = frame.roles.get(role, role)
        name = frame.text(asked["name"])
        while True:
            fails = attempt <= asked["tries"] or frame.turns <= asked["turns"]
            word = asked["word"] if fails else "ok"
            if HAPPENS.get(word):
                self._happens(device, action, name, asked.get("to"), frame)
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

    def _happens(self, device, action, name, to, frame):
        if action == "set":
            self.states[device] = ANY if device in frame.cut else to
        if action == "shoot" and device in frame.cut:
            self.maybe[name] += 1
        elif action == "shoot":
            self.newest[device] = name
            self.happened[name] += 1
            self.focus[name].append({d: self._state(d, frame) for d in ("a", "b")})

    def _state(self, device, frame):
        value = self.states.get(device, ANY)
        return ANY if device in frame.beside else value

    def _find_out(self, step, device, happened):
        policy = step.get("on_unknown", "probe")
        if policy == "probe" and happened:
            return "happened"
        if policy == "probe" and device in self.newest:
            return ""
        return policy if policy in ("skip", "repeat") else self.answers[step["id"]]
