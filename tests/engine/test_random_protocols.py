"""Random protocols on the real engine and wire, against a small independent interpreter."""

import itertools
import tempfile
from collections import Counter, deque
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


def in_turn(step, name):
    """The same step in an iteration beside others: its actions have names of its own."""
    if isinstance(step, list):
        return [in_turn(one, name) for one in step]
    if not isinstance(step, dict):
        return step
    if "do" in step:
        own = {**step["with"], "name": f"{step['with']['name']}.${{{{ {name} }}}}"}
        more = {k: in_turn(v, name) for k, v in step.items() if k == "fallback"}
        return {**step, **more, "with": own}
    return {key: in_turn(value, name) for key, value in step.items()}


def at_once(steps, count, limit):
    """All at once, or two of them where no failure ends the loop: else chance says how many begin."""
    name = f"i{next(NUMBERS)}"
    kept = {} if limit is None else {"keep_going": {"max_failed": limit} if limit < 5 else True}
    return {
        "foreach": {name: list(range(count))}, "at_once": 2 if limit == 5 else max(2, count),
        "steps": in_turn(steps, name), **kept,
    }  # fmt: skip


told = st.just({"notify": "somebody"})


def watched(holds, then, steps):
    """A watch that is right from the beginning, or never."""
    when = f"${{{{ status.a.level > {-1000 if holds else 1000} mm }}}}"
    return {"watch": [{"when": when, "then": then}], "steps": steps}


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
    beside = st.builds(at_once, body, st.integers(2, 3), st.sampled_from([None, 0, 1, 5]))
    reserved = st.builds(lambda steps: {"reserve": ["a", "b"], "steps": steps}, body)
    then = told | st.just({"fail": "seen"}) | st.lists(plain, min_size=1, max_size=2)
    watch = st.builds(watched, st.booleans(), then, body)
    return group | loop | beside | reserved | watch


nested = st.recursive(actions | sets | told, groups, max_leaves=6)
aside = st.builds(
    lambda steps: {"steps": steps, "mode": "background"}, st.lists(nested, min_size=1, max_size=2)
)
protocols = st.lists(nested | aside, min_size=1, max_size=4)


class Sent:
    """What has to be sent: one action, or others in order or (`beside`) in any; `keeps` its devices."""

    def __init__(self, name="", device="", *, beside=False, keeps=False):
        self.name, self.device, self.beside, self.keeps = name, device, beside, keeps
        self.within = []

    def add(self, one):
        self.within.append(one)
        return one

    def leaves(self):
        return [self] if self.name else [leaf for one in self.within for leaf in one.leaves()]


class Oracle:
    """P = [A1, ..., AT], interpreted: `sent` is what is sent, with the order that it must have."""

    def __init__(self):
        self.calls, self.sent = Counter(), Sent()

    def whole(self, steps):
        """A protocol: what is in the background goes on beside its later steps, even if one has failed."""
        here, good = self.sent, True
        for step in steps:
            if "mode" not in step:
                if not self.step(step, {}, here.add(Sent())):
                    return False
                continue
            fork = here.add(Sent(beside=True))
            good &= self.steps(step["steps"], {}, fork.add(Sent()))
            here = fork.add(Sent())
        return good

    def steps(self, steps, names, sent):
        return all(self.step(step, names, sent.add(Sent())) for step in steps)

    def step(self, step, names, sent):
        if "parallel" in step:
            return self.set(step, names, sent)
        for _ in range(step.get("retry", 1)):
            if self.once(step, names, sent.add(Sent())):
                return True
        if any(self.step(other, names, sent.add(Sent())) for other in step.get("fallback", [])):
            return True
        return step.get("on_error") == "continue"

    def once(self, step, names, sent):
        if "notify" in step:
            return True
        if "fail" in step:
            return False
        if "do" in step:
            return self.device(step, names, sent)
        if "foreach" in step:
            return self.loop(step, names, sent)
        sent.keeps = "reserve" in step
        return self.steps(self.instead(step) or step["steps"], names, sent)

    def instead(self, step):
        """What takes the place of the steps, where a watch is right; telling leaves them."""
        for watch in step.get("watch", []):
            then = watch["then"]
            if "-1000" in watch["when"] and "notify" not in then:
                return then if isinstance(then, list) else [then]
        return None

    def device(self, step, names, sent):
        name, words = step["with"]["name"], step["with"]["script"].split(",")
        for item, value in names.items():
            name = name.replace(f"${{{{ {item} }}}}", str(value))
        sent.add(Sent(name, step["do"][0]))
        self.calls[name] += 1
        return words[min(self.calls[name], len(words)) - 1] == "ok"

    def set(self, step, names, sent):
        # A retried set passes the retry to its members: only failed ones are sent again.
        sent.beside, ok = True, True
        for member in step["parallel"]:
            strand = sent.add(Sent())
            for _ in range(step.get("retry", 1)):
                if self.device(member, names, strand):
                    break
            else:
                ok = False
        return ok

    def loop(self, step, names, sent):
        ((name, items),) = step["foreach"].items()
        failed, kept = 0, step.get("keep_going")
        limit = len(items) if kept is True else (kept or {}).get("max_failed")
        sent.beside = "at_once" in step
        for item in items:
            if not self.steps(step["steps"], {**names, name: item}, sent.add(Sent())):
                failed += 1
                if not sent.beside and (limit is None or failed > limit):
                    return False
        return not failed or (limit is not None and failed <= limit and failed < len(items))


def broken_rules(sent, names):
    """Where what was sent, by its names in order, is not what had to be."""
    turns = {}
    for at, name in enumerate(names):
        turns.setdefault(name, deque()).append(at)
    leaves = sent.leaves()
    if Counter(leaf.name for leaf in leaves) != Counter(names):
        return [f"{Counter(names)} instead of {Counter(leaf.name for leaf in leaves)}"]
    at = {leaf: turns[leaf.name].popleft() for leaf in leaves}  # one name is in one strand only
    return list(_broken(sent, at))


def _broken(sent, at):
    parts = [[at[leaf] for leaf in one.leaves()] for one in sent.within]
    for before, after in itertools.pairwise(filter(None, parts)):
        if not sent.beside and max(before) > min(after):
            yield f"{before} is not before {after}"
    own = {at[leaf] for leaf in sent.leaves()}
    if sent.keeps and own and len(own) != max(own) - min(own) + 1:
        yield f"{sorted(own)} have others between them"
    for one in sent.within:
        yield from _broken(one, at)


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
        expected = oracle.whole(steps)

        status = start(checked, folder / "runs")
        (run,) = (folder / "runs").iterdir()
        sent = [c["name"] for c in bench.calls(run.name) if c["word"] != "done"]

    assert status == (0 if expected else 1)
    assert broken_rules(oracle.sent, sent) == []
