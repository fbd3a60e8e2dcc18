"""Random protocols on the real engine and wire, against a small independent interpreter."""

import itertools
import tempfile
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from labrun.engine.check import check_file
from labrun.engine.commands.run import start

NUMBERS = itertools.count()
SCRIPTS = ["ok", "Broken", "Broken,ok", "ok,Broken", "Broken,Broken,ok"]


def act(device, script, retry, on_error, fallback):
    step = {"do": f"{device}.act", "with": {"name": f"n{next(NUMBERS)}", "script": script}}
    step |= {"retry": retry} if retry else {}
    step |= {"on_error": "continue"} if on_error else {}
    step |= {"fallback": [fallback]} if fallback else {}
    return step


plain = st.builds(
    act, st.sampled_from("ab"), st.sampled_from(SCRIPTS), st.sampled_from([None, 2, 3]),
    st.booleans(), st.none(),
)  # fmt: skip
actions = plain | st.builds(
    act, st.sampled_from("ab"), st.sampled_from(SCRIPTS), st.sampled_from([None, 2]),
    st.just(False), plain,
)  # fmt: skip
sets = st.builds(
    lambda one, two, retry: {
        "parallel": [
            act("a", one, None, False, None),
            act("b", two, None, False, None),
        ],
        **({"retry": retry} if retry else {}),
    },
    st.sampled_from(SCRIPTS), st.sampled_from(SCRIPTS), st.sampled_from([None, 2]),
)  # fmt: skip


def groups(inner):
    body = st.lists(inner, min_size=1, max_size=3)
    group = st.builds(
        lambda steps, retry: {"steps": steps} | ({"retry": retry} if retry else {}),
        body, st.sampled_from([None, 2]),
    )  # fmt: skip
    loop = st.builds(
        lambda steps, count, limit: {
            "foreach": {f"i{next(NUMBERS)}": list(range(count))},
            "steps": steps,
            **({} if limit is None else {"keep_going": {"max_failed": limit}}),
        },
        body, st.integers(1, 3), st.sampled_from([None, 0, 1, 5]),
    )  # fmt: skip
    return group | loop


protocols = st.lists(st.recursive(actions | sets, groups, max_leaves=6), min_size=1, max_size=4)


class Oracle:
    """P = [A1, ..., AT], interpreted: `sent` is a list of sets of actions sent together."""

    def __init__(self):
        self.calls, self.sent = Counter(), []

    def steps(self, steps):
        return all(self.step(step) for step in steps)

    def step(self, step):
        if "parallel" in step:
            return self.set(step)
        for _ in range(step.get("retry", 1)):
            if self.once(step):
                return True
        if any(self.step(other) for other in step.get("fallback", [])):
            return True
        return step.get("on_error") == "continue"

    def once(self, step):
        if "do" in step:
            self.sent.append(Counter([step["with"]["name"]]))
            return self.device(step)
        return self.loop(step) if "foreach" in step else self.steps(step["steps"])

    def device(self, step):
        name, words = step["with"]["name"], step["with"]["script"].split(",")
        self.calls[name] += 1
        return words[min(self.calls[name], len(words)) - 1] == "ok"

    def set(self, step):
        # A retried set passes the retry to its members: only failed ones are sent again.
        together, ok = Counter(), True
        for member in step["parallel"]:
            for _ in range(step.get("retry", 1)):
                together[member["with"]["name"]] += 1
                if self.device(member):
                    break
            else:
                ok = False
        self.sent.append(together)
        return ok

    def loop(self, step):
        (items,) = step["foreach"].values()
        failed, limit = 0, step.get("keep_going", {}).get("max_failed")
        total = len(items)
        for _ in items:
            if not self.steps(step["steps"]):
                failed += 1
                if limit is None or failed > limit:
                    return False
        return not failed or failed < total


@settings(
    max_examples=40, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(protocols)
def test_what_is_sent_and_how_the_run_ends_is_what_the_interpreter_says(bench, steps):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        protocol = {"labrun": 1, "name": "o", "devices": {"a": "scripted@1", "b": "scripted@1"}}
        with (folder / "o.yaml").open("w") as file:
            YAML(typ="safe", pure=True).dump({**protocol, "steps": steps}, file)
        checked = check_file(folder / "o.yaml", lab=bench.lab)
        assert checked.ok, checked.problems
        oracle = Oracle()
        expected = oracle.steps(steps)

        status = start(checked, folder / "runs")
        (run,) = (folder / "runs").iterdir()
        sent = [c["name"] for c in bench.calls(run.name) if c["word"] != "done"]

    assert status == (0 if expected else 1)
    for together in oracle.sent:
        begun, sent = sent[: together.total()], sent[together.total() :]
        assert Counter(begun) == together
    assert sent == []
