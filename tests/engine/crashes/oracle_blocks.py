"""The outcomes of sets, races, groups, branches, loops and used protocols."""

import itertools
from collections import Counter

from crashes_oracle_acts import ANY, Acts, Failed
from crashes_walk import devices, sets


class Blocks(Acts):
    """Steps that hold steps; `step` and `steps` are the ladder's, see oracle.py."""

    def _parallel(self, step, frame):
        busy = frame.devices(sets(step["parallel"]))
        failures = []
        if all("reserve" in member.get("steps", [{}])[0] for member in step["parallel"]):
            self._in_turns(step, frame)
            return
        for member in step["parallel"]:  # of a set that cancels, only the first can fail
            own = frame.devices(devices([member]))
            if failures and step.get("on_failure") == "cancel":
                frame = frame.but(cut=own)
            there = frame.but(beside=frame.beside | busy - own)
            failure = self._member(member, there, step.get("retry", 1))
            failures += [failure] if failure else []
        if failures:
            raise failures[0]

    def _member(self, member, frame, tries):
        """Why a member of a set failed, if it did; the retry of the set is its members'."""
        for turn in range(tries):
            try:
                self.step(member, frame.but(turns=frame.turns + turn))
            except Failed as again:
                failure = again
                if not self.may_again(again, None):
                    break
            else:
                return None
        return failure

    def _any(self, step, frame):
        """One wins; what the others do may happen or not, and what the winner does happens."""
        there = frame.but(cut=frame.cut | frame.devices(devices(step["any"])))
        done, failure = [], None
        for member in step["any"]:
            before = Counter(self.maybe)
            lost = self._member(member, there, step.get("retry", 1))
            failure = lost or failure
            done += [] if lost else [set(self.maybe - before)]
        if not done:
            raise failure
        self.either.append(done)

    def _in_turns(self, step, frame):
        """Members that share devices, each of them in its own time."""
        for member in step["parallel"]:
            self.step(member, frame.but(beside=frozenset("ab"), shared=True))
        self._nobody_knows(step["parallel"], frame)

    def _nobody_knows(self, steps, frame):
        """Which of those beside each other was the last to set a device."""
        for device in frame.devices(sets(steps)):
            self.states[device] = ANY

    def _steps(self, step, frame):
        if "watch" in step and frame.holds(step["watch"][0]["when"]):
            return self._list(step["watch"][0]["then"], frame)
        if "reserve" in step and frame.shared:  # others have used them; now nobody does
            own = frame.devices(step["reserve"])
            self.states |= dict.fromkeys(own, ANY)
            frame = frame.but(beside=frame.beside - own)
        return self._list(step["steps"], frame)

    def _list(self, steps, frame):
        inner = frame if frame.loops else frame.but(aside=[])
        result = self.steps(steps, inner)
        if inner is not frame:
            self.join(inner)
        return result

    def _if(self, step, frame):
        return self._list(step.get("then" if frame.holds(step["if"]) else "else", []), frame)

    # --- loops

    def _foreach(self, step, frame):
        if "at_once" in step:
            there = frame.but(beside=frozenset("ab"), shared=True)
            ((item, values),) = step["foreach"].items()
            counts = self._turns(step, there, ({item: value} for value in values))
            self._nobody_knows(step["steps"], frame)
            return counts
        ((item, values),) = step["foreach"].items()
        return self._turns(step, frame, ({item: value} for value in values))

    def _repeat(self, step, frame):
        return self._turns(step, frame, ({} for _ in range(step["repeat"])))

    def _while(self, step, frame):
        def turns():
            for index in itertools.count():
                if not frame.holds(step["while"]):
                    return
                if index >= step["max"]:
                    raise Failed("MaxReached")
                yield {}

        return self._turns(step, frame, turns())

    def _turns(self, step, frame, turns):
        counts = Counter()
        for index, own in enumerate(turns):
            counts[self._iteration(step, own, index, frame, counts)] += 1
        if counts["failed"] and not counts["succeeded"]:
            raise Failed("NothingSucceeded")
        return counts

    def _iteration(self, step, own, index, frame, counts):
        there = frame.but(
            names={**frame.names, **own}, results=dict(frame.results), aside=[], loops=True,
            inside=(*frame.inside, (step["id"], index, frame.turns)),
            keys=(*frame.keys, str(index)),
        )  # fmt: skip
        fate = "succeeded"
        try:
            self.steps(step["steps"], there)
            self.join(there)
        except Failed as failure:
            limit = step.get("keep_going", {}).get("max_failed", 0)
            if failure.stop or not (failure.skip or counts["failed"] + 1 <= limit):
                raise
            fate = "failed"
            self.holes += 1
        self._collect(step, fate, there)
        return fate

    def _collect(self, step, fate, frame):
        cells = (self._cell(raw, frame) for raw in step["collect"].values())
        header = ",".join(["key", *step["collect"], "fate"])
        row = ["/".join(frame.keys), *cells, fate]
        self.tables.setdefault(header, []).append(",".join(row))

    def _cell(self, raw, frame):
        names = str(raw).removeprefix("${{ ").removesuffix(" }}").split(".")
        if names[0] == "steps":
            result = frame.results.get(names[1])
            return result[names[2]] or "" if result else ""
        return str({**frame.values, **frame.names}.get(names[0], raw))

    # --- used protocols

    def _use(self, step, frame):
        """Its steps, then its `finally`, which may be begun and stopped where it may be cut off."""
        other = step["use"]
        mapped = step.get("devices", {})
        roles = {role: frame.roles.get(mapped.get(role, role), mapped.get(role, role))
                 for role in other["devices"]}  # fmt: skip
        names = {f"params.{name}": frame.text(raw) for name, raw in step.get("with", {}).items()}
        there = frame.but(
            names=names, values={}, results={}, roles=roles, loops=False, aside=[]
        )  # fmt: skip
        failure = None
        try:
            self._list(other["steps"], there)
        except Failed as why:
            failure = why
        try:
            self._last(other.get("finally", []), there)
        except Failed as why:
            failure = failure or why
        if failure:
            raise failure
        outputs = {name: raw.split(".")[1] for name, raw in other.get("outputs", {}).items()}
        return {name: (there.results.get(i) or {}).get("name") for name, i in outputs.items()}

    def _last(self, steps, frame):
        before = Counter(self.happened)
        try:
            self.every(steps, frame.but(cut=frozenset(), results={}))
        finally:
            self._tidied(steps, frame, before)

    def _tidied(self, steps, frame, before):
        self.tidy |= set(self.happened - before)
        if frame.cut:
            self.maybe += self.happened - before
            if frame.turns > 1:  # cut off before this turn, it never got there
                self.happened = before
            for device in frame.devices(sets(steps)):
                self.states.pop(device, None)
