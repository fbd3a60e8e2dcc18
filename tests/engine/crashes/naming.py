"""Names for what was drawn: steps, loops, tags of used protocols; and the answers by id."""

import copy

from crashes_walk import acts, walk, within

ALL = ["Broken", "Half", "Foggy", "Lost"]
STURDY = {"attempts": 8, "on": ALL}
OTHER_NAMES = {"a": "one", "b": "two"}
CONTRACTS = {"a": "bench@1", "b": "bare@1"}


class Namer:
    """Names follow the order of the text, so that the same draw is the same protocol.

    `told` is what tells one doing of a step from another: the names of the loops around it, and in
    a used protocol the tag that it was given.
    """

    def __init__(self, *, sturdy):
        self.count = 0
        self.sturdy = sturdy
        self.answers = {}

    def all(self, steps, told=()):
        return [self.one(step, told) for step in steps]

    def one(self, step, told):
        self.count += 1
        number = self.count
        step = copy.deepcopy(step)
        if "do" in step:
            self._act(step, number, told)
        if "answer" in step:
            step["id"] = f"q{number}"
            self.answers[step["id"]] = step.pop("answer")
        if "fallback" in step:
            step["fallback"] = [self._other(other, told) for other in step["fallback"]]
        for key in ("parallel", "any", "then", "else"):
            if key in step:
                step[key] = self.all(step[key], told)
        for watch in step.get("watch", []):
            watch["then"] = self.all(watch["then"], told)
        if "use" in step:
            return self._use(step, number, told)
        if "while" in step:
            return self._while(step, number, told)
        if "foreach" in step:
            name = f"i{number}"
            step["foreach"] = {name: step["foreach"]}
            self._loop(step, number, (*told, name), name)
        elif "repeat" in step:
            self._loop(step, number, told, None)
        elif "steps" in step:
            step["steps"] = self.all(step["steps"], told)
        return step

    def _other(self, other, told):
        return self.all(other, told) if isinstance(other, list) else self.one(other, told)

    def _act(self, step, number, told):
        step["id"] = f"s{number}"
        step["with"]["name"] = self._told(f"n{number}", told)
        if step["do"].endswith("set"):
            step["with"]["to"] = number
        if step.get("on_unknown") == "ask" and not self.sturdy:
            self.answers[step["id"]] = ["repeat", "skip", "stop", "repeat"][number % 4]
        else:
            self.answers[step["id"]] = "repeat"
        if self.sturdy:
            step.pop("on_unknown", None)
            step["retry"] = STURDY

    def _told(self, name, told):
        return "-".join([name, *(f"${{{{ {one} }}}}" for one in told)])

    # --- loops

    def _loop(self, step, number, told, name):
        step["id"] = f"l{number}"
        step["steps"] = self.all(step["steps"], told)
        columns = {f"k{number}": 1, **({name: f"${{{{ {name} }}}}"} if name else {})}
        if not any(s.get("mode") for s in walk(step["steps"])):
            columns[f"v{number}"] = "${{ v }}"
        for inner in step["steps"]:
            if "do" in inner and not inner["do"].endswith("set"):
                columns[f"c{inner['id']}"] = f"${{{{ steps.{inner['id']}.name }}}}"
            if inner.get("use", {}).get("outputs") and "fallback" not in inner:
                columns[f"c{inner['id']}"] = f"${{{{ steps.{inner['id']}.n }}}}"
        step["collect"] = columns

    def _while(self, step, number, told):
        """Turns are counted by a name that is set before the loop, and in it where it was drawn."""
        name, limit, place = f"w{number}", step["while"], step.pop("counts_at")
        counts = {"set": {name: f"${{{{ {name} + 1 }}}}"}}
        step["while"] = f"${{{{ {name} < {limit} }}}}"
        self._loop(step, number, told, None)
        step["steps"].insert(min(place, len(step["steps"])), counts)
        return {"steps": [{"set": {name: 0}}, step]}

    # --- used protocols

    def _use(self, step, number, told):
        drawn, twice, renamed = step["use"], step.pop("twice"), step.pop("renamed")
        body = [{"set": {"v": 0}}, *self.all(drawn["steps"], ("params.tag",))]
        other = {"params": {"tag": {"type": "string"}}, "steps": body}
        if drawn["finally"]:
            other["finally"] = self.all(drawn["finally"], ("params.tag",))
        if drawn.get("on_resume"):
            other["on_resume"] = self.all(drawn["on_resume"], ("params.tag",))
        self._roles(step, other, renamed)
        named = [s["id"] for s in body if "do" in s and not s["do"].endswith("set")]
        if named and not body[-1].get("mode"):
            other["outputs"] = {"n": f"${{{{ steps.{named[0]}.name }}}}"}
        step["use"] = other
        first = {**step, "id": f"u{number}", "with": {"tag": self._told(f"u{number}", told)}}
        if not twice:
            return first
        again = {**step, "id": f"u{number}b", "with": {"tag": self._told(f"u{number}b", told)}}
        again.pop("fallback", None)  # its ids would occur twice
        return {"steps": [first, again]}

    def _roles(self, step, other, renamed):
        everywhere = within(other)
        names = OTHER_NAMES if renamed else {}
        other["devices"] = {}
        for inner in self._own(everywhere):
            for part in [inner["do"][0]] if "do" in inner else self._ours(inner):
                other["devices"][names.get(part, part)] = CONTRACTS[part]
            if "do" in inner:
                role, _, action = inner["do"].partition(".")
                inner["do"] = f"{names.get(role, role)}.{action}"
            elif names:
                inner["devices"] = {
                    role: names.get(ours, ours) for role, ours in self._played(inner).items()
                }
        for group in self._outside(everywhere):
            if "reserve" in group:
                group["reserve"] = [names.get(role, role) for role in group["reserve"]]
        if names:
            step["devices"] = {n: ours for ours, n in names.items() if n in other["devices"]}

    def _own(self, steps):
        """Actions and uses in these steps, those within used protocols left out."""
        return [s for s in self._outside(steps) if "do" in s or "use" in s]

    def _outside(self, steps):
        inside = [id(s) for step in walk(steps) if "use" in step for s in self._within(step)]
        return [s for s in walk(steps) if id(s) not in inside]

    def _within(self, step):
        return walk(within(step["use"]))

    def _played(self, step):
        return {role: step.get("devices", {}).get(role, role) for role in step["use"]["devices"]}

    def _ours(self, step):
        return self._played(step).values()


def hides(steps, *phases):
    """Whether a shot may come before one that is older in the text, or not at all."""
    shoots = any(step["do"].endswith("shoot") for phase in phases for step in phase)
    odd = ("at_once", "watch", "mode", "on_failure", "any", "use", "timeout")
    return shoots or any(s.get(key) for s in walk(steps) for key in odd)


def patient(protocol):
    """The same protocol, in which every action is tried until it succeeds."""
    protocol = copy.deepcopy(protocol)
    for step in acts(protocol["steps"]):
        step["retry"] = STURDY
    return protocol
