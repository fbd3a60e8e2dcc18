"""Random protocols of 3 to 12 actions, and the laboratory in which they are simulated."""

import json
from pathlib import Path
from random import Random
from typing import Any

from ..check import Checked, check_file

SETTING = {
    "type": "object",
    "required": ["n", "to"],
    "properties": {"n": {"type": "integer"}, "to": {"type": "integer"}},
}
NEWEST = {"type": "object", "properties": {"goal_id": {"type": ["string", "null"]}}}
ACTIONS: dict[str, Any] = {
    "set": {"effect": "idempotent", "sets": "channel {n}", "cancel": True, "duration": "200 ms",
            "params": SETTING},
    "look": {"effect": "pure", "duration": "100 ms"},
    "fire": {"effect": "once", "probe": "last", "duration": "1 s"},
    "last": {"effect": "pure", "duration": "100 ms", "returns": NEWEST},
    "rest": {"effect": "idempotent", "duration": "100 ms"},
}  # fmt: skip
KINDS: dict[str, dict[str, Any]] = {
    "a": {"on_lease_lapse": "safe"},  # what is known of its goals lies beside its ledger
    "b": {"concurrent": True, "on_lease_lapse": "cancel"},
    "c": {},  # it remembers no goals: a person is asked
}


def random_protocol(random: Random, folder: Path) -> Checked:
    """Draw one, write it with its lab, and check it."""
    contracts = []
    for name, more in KINDS.items():
        told = {"type": f"{name}@1", "safe_state": ["rest"], "actions": ACTIONS, **more}
        (folder / f"{name}.json").write_text(json.dumps(told))
        contracts.append(f"./{name}.json")
    devices = {n: {"contract": f"{n}@1", "url": f"http://{n}"} for n in KINDS}
    lab = {"name": "simulated", "simulated": True, "contracts": contracts, "devices": devices}
    (folder / "lab.json").write_text(json.dumps(lab))
    steps = _Draw(random).protocol(random.randint(3, 12))
    protocol = {"labrun": 1, "name": "drawn", "devices": {n: f"{n}@1" for n in KINDS}, **steps}
    (folder / "drawn.json").write_text(json.dumps(protocol))
    checked = check_file(folder / "drawn.json", lab=folder / "lab.json")
    assert checked.ok, checked.problems
    return checked


class _Draw:
    def __init__(self, random: Random) -> None:
        self.random = random
        self.count = 0

    def protocol(self, actions: int) -> dict[str, Any]:
        steps = self._steps(actions, 2)
        if self.count == 0 or "fire" not in json.dumps(steps):
            steps.append(self._act("fire"))
        drawn: dict[str, Any] = {"steps": steps}
        if self.random.random() < 0.5:
            drawn["on_resume"] = [self._act("set"), self._act("look")]
        if self.random.random() < 0.5:
            drawn["finally"] = [self._act("set")]
        return drawn

    def _steps(self, actions: int, deep: int) -> list[dict[str, Any]]:
        steps: list[dict[str, Any]] = []
        while actions > 0:
            share = self.random.randint(1, actions)
            kind = self.random.choice(("act", "act", "loop", "set", "group")) if deep else "act"
            if kind == "act" or share == 1:
                steps.append(self._act())
                share = 1
            elif kind == "loop":
                steps.append(self._loop(share, deep))
            elif kind == "group":
                self.count += 1
                name = f"g{self.count}"  # by which its turns are told apart
                steps.append({"id": name, "steps": self._steps(share, deep - 1), "retry": 2})
            else:
                share = min(share, 3)
                steps.append({"parallel": self._members(share)})
            actions -= share
        return steps

    def _loop(self, share: int, deep: int) -> dict[str, Any]:
        self.count += 1
        turns = list(range(self.random.randint(2, 3)))
        return {
            "id": f"l{self.count}", "foreach": {f"i{self.count}": turns},
            "steps": self._steps(share, deep - 1),
        }  # fmt: skip

    def _members(self, share: int) -> list[dict[str, Any]]:
        """Beside one another: either what sets something, each its own, or what finds it set."""
        devices = self.random.choice(["b" * share, self.random.sample(sorted(KINDS), share)])
        if self.random.random() < 0.3:
            return [self._act("set", device, self.count + 10) for device in devices]
        return [self._act(self.random.choice(("fire", "fire", "look")), d) for d in devices]

    def _act(self, action: str = "", device: str = "", channel: int = 0) -> dict[str, Any]:
        self.count += 1
        action = action or self.random.choice(("fire", "fire", "fire", "set", "set", "look"))
        device = device or self.random.choice("aabc")
        step: dict[str, Any] = {"id": f"s{self.count}", "do": f"{device}.{action}"}
        if action == "set":
            step["with"] = {"n": channel or self.random.randint(1, 2), "to": self.count}
        return step
