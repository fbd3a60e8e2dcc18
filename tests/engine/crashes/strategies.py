"""Random protocols, fault schedules and kill points, as the test draws them.

What is drawn has no names yet; `named` gives them in the order of the text, so that the same draw
is the same protocol.
"""

import copy

from hypothesis import strategies as st

FINE = ("ok", 0, 0)
FAULTS = [("Broken", 1, 0), ("Broken", 2, 0), ("Broken", 99, 0), ("Broken", 0, 1)]
FAILS_AT_FIRST = [("Broken", 1, 0), ("Broken", 2, 0)]
UNKNOWN = [("happened!", 1, 0), ("dark", 1, 0)]
SHOT_FAULTS = [*FAULTS, ("Half", 1, 0), ("Half", 99, 0), *UNKNOWN]
DEATHS = [("die+", 1, 0), ("die-", 1, 0)]
ALL = ["Broken", "Half", "Foggy", "Lost"]
STURDY = {"attempts": 8, "on": ALL}

retries = st.sampled_from([None, None, 2, 3, {"attempts": 2, "on": ["Half", "Broken"]}])
devices = st.sampled_from("ab")
policies = st.sampled_from([None, None, None, "ask", "skip", "repeat"])


def without_none(**said):
    return {key: value for key, value in said.items() if value is not None}


def do(device, action, script, retry=None, policy=None, on_error=None, ms=0):
    word, tries, turns = script
    asked = {"word": word, "tries": tries, "turns": turns, "ms": ms} if word != "ok" else {"ms": ms}
    asked |= {"to": 1} if action == "set" else {}
    shot = {"on_unknown": policy if action == "shoot" else None}
    return without_none(
        do=f"{device}.{action}", **{"with": asked}, retry=retry, on_error=on_error, **shot
    )


def often(usual, rare):
    return st.one_of(st.just(usual), st.just(usual), rare)


quick = st.sampled_from([0, 0, 3, 8, 20])
goes_on = often(None, st.just("continue"))
sets = st.builds(
    do, devices, st.just("set"), often(FINE, st.sampled_from(FAULTS)), retries,
    on_error=goes_on, ms=quick,
)  # fmt: skip
looks = st.builds(
    do, devices, st.just("look"), often(FINE, st.sampled_from(FAULTS)), retries,
    on_error=goes_on, ms=quick,
)  # fmt: skip
shots = st.builds(
    do, devices, st.just("shoot"), often(FINE, st.sampled_from(SHOT_FAULTS)), retries, policies,
    on_error=goes_on, ms=quick,
)  # fmt: skip
deadly = st.builds(do, devices, st.just("shoot"), st.sampled_from(DEATHS), st.just(STURDY))
counted = st.just({"set": {"v": "${{ v + 1 }}"}})
instants = st.sampled_from(
    [
        {"log": "on"},
        {"wait": "3 ms"},
        {"fail": "enough", "when": "${{ v > 1 }}"},
        {"confirm": "go?"},
    ]
)
aside = st.builds(
    lambda step: {**step, "mode": "background", "on_error": "continue"},
    st.builds(
        do, devices, st.just("look"), often(FINE, st.sampled_from(FAULTS)), retries, ms=quick
    )
    | st.builds(
        do, devices, st.just("shoot"), often(FINE, st.sampled_from(SHOT_FAULTS)), retries,
        st.sampled_from([None, None, "repeat"]), ms=quick,
    ),
)  # fmt: skip
asks = st.builds(
    lambda choice: {"ask": "what now?", "choices": ["repeat", "skip", "stop"], "answer": choice},
    st.sampled_from(["skip", "skip", "stop"]),
)
actions = sets | shots | shots | looks


def with_fallback(step, alternatives):
    step = {key: value for key, value in step.items() if key != "on_error"}
    return {**step, "fallback": alternatives}


def repeated(step):
    """A step that fails in its first turn, so that a person's `repeat` helps."""
    step = copy.deepcopy(step)
    step["with"] |= {"word": "Broken", "tries": 0, "turns": 1}
    ask = {"ask": "again?", "choices": ["repeat", "skip", "stop"], "answer": "repeat"}
    return with_fallback(step, [ask])


others = st.lists(
    actions | st.lists(actions, min_size=1, max_size=2), min_size=1, max_size=2
)  # fmt: skip
fallen = (
    st.builds(with_fallback, actions, others)
    | st.builds(with_fallback, shots, st.builds(lambda ask: [ask], asks))
    | st.builds(repeated, sets | shots)
)
together = st.builds(
    lambda one, two, retry: without_none(
        parallel=[{**one, "do": "a" + one["do"][1:]}, {**two, "do": "b" + two["do"][1:]}],
        retry=retry,
    ),
    sets | looks | shots.filter(lambda s: s.get("on_unknown") is None),
    sets | looks | shots.filter(lambda s: s.get("on_unknown") is None),
    st.sampled_from([None, None, 2]),
)  # fmt: skip
cancelling = st.builds(
    lambda bad, good: {
        "parallel": [{**bad, "do": "a" + bad["do"][1:]}, {**good, "do": "b" + good["do"][1:]}],
        "on_failure": "cancel",
    },
    st.builds(do, devices, st.sampled_from(["set", "look"]), st.sampled_from(FAULTS), ms=quick),
    st.builds(
        do, devices, st.sampled_from(["set", "look", "shoot", "shoot"]), st.just(FINE), ms=quick
    ),
)  # fmt: skip


def groups(inner):
    body = st.lists(inner, min_size=1, max_size=3)
    instead = st.lists(actions | together, min_size=1, max_size=3)
    asides = st.builds(lambda steps, step: [*steps, step], body, aside)
    group = st.builds(
        lambda steps, retry, on_error: without_none(steps=steps, retry=retry, on_error=on_error),
        body | body | asides, st.sampled_from([None, 2]), goes_on,
    )  # fmt: skip
    fallen_group = st.builds(
        lambda steps, retry, other: without_none(steps=steps, retry=retry, fallback=[other]),
        body, st.sampled_from([None, None, 2]), instead,
    )  # fmt: skip
    loop = st.builds(
        lambda steps, count, limit, retry: without_none(
            foreach=list(range(count)), steps=steps, retry=retry,
            keep_going=None if limit is None else {"max_failed": limit}, collect={},
        ),
        body | asides,
        st.integers(1, 3), st.sampled_from([None, 0, 1, 5]), st.sampled_from([None, None, 2]),
    )  # fmt: skip
    return group | loop | loop | fallen_group


leaves = actions | actions | fallen | together | cancelling | counted | instants
calm = st.lists(st.recursive(leaves, groups, max_leaves=7), min_size=1, max_size=4)
rough = st.lists(
    st.recursive(leaves | deadly | deadly | deadly, groups, max_leaves=6),
    min_size=1, max_size=4,
)  # fmt: skip
calming = st.builds(do, devices, st.sampled_from(["set", "look"]), st.just(FINE))
tidying = st.builds(
    do, devices, st.just("shoot"), often(FINE, st.sampled_from(UNKNOWN)), st.just(3), ms=quick
)  # fmt: skip
stubborn = st.builds(
    do, devices, st.sampled_from(["set", "look"]), often(FINE, st.sampled_from(FAILS_AT_FIRST)),
    ms=quick,
) | st.builds(
    do, devices, st.just("shoot"), often(FINE, st.sampled_from([*FAILS_AT_FIRST, *UNKNOWN])),
    ms=quick,
)  # fmt: skip
finals = st.lists(calming | tidying, max_size=2)
WHENS = ["before", "torn", "after", "later"]


@st.composite
def kills(draw, *touches):
    """Up to three kills; the first cannot come before anything is on disk, since no run is then."""
    drawn = draw(
        st.lists(
            st.tuples(st.integers(1, 25), st.sampled_from(WHENS), st.sampled_from(touches)),
            min_size=1, max_size=3,
        )
    )  # fmt: skip
    (nth, when, touch), *others = drawn
    return [(max(2, nth), when, touch), *others]


@st.composite
def crashes(draw, steps, *touches, sturdy=False):
    """A protocol, the answers to its questions, and when its engines are killed."""
    ending = draw(finals)
    protocol, answers = named(draw(steps), ending, draw(finals), sturdy=sturdy)
    return protocol, answers, draw(kills(*touches))


def engine_dies():
    """The engine is killed; the device server lives."""
    return crashes(calm, "")


def devices_are_touched():
    """Between two engines the device server is killed, or one device or all are stopped."""
    return crashes(calm, "", "stop", "stop b", "restart", sturdy=True)


def server_dies():
    """The device server dies in the middle of its actions, the engine now and then."""
    return crashes(rough, "", "restart", sturdy=True) | crashes(rough, "", sturdy=True)


def run_fails():
    """Nothing is tried again by itself: the run fails, and is resumed by hand until it succeeds."""
    flat = st.lists(stubborn, min_size=1, max_size=3)
    loop = st.builds(
        lambda steps, count: {"foreach": list(range(count)), "steps": steps, "collect": {}},
        flat, st.integers(1, 2),
    )  # fmt: skip
    steps = st.lists(stubborn | stubborn | loop | counted, min_size=1, max_size=4)
    return crashes(steps, "", "stop", "restart")


def patient(protocol):
    """The same protocol, in which every action is tried until it succeeds."""
    protocol = copy.deepcopy(protocol)
    for step in walk(protocol["steps"]):
        if "do" in step:
            step["retry"] = STURDY
    return protocol


class Namer:
    """Names for steps, ids for what is asked about, loop names; and the answers by id."""

    def __init__(self, *, sturdy):
        self.count = 0
        self.sturdy = sturdy
        self.answers = {}

    def all(self, steps, loops=()):
        return [self.one(step, loops) for step in steps]

    def one(self, step, loops):
        self.count += 1
        number = self.count
        step = copy.deepcopy(step)
        if "do" in step:
            self._act(step, number, loops)
        if "answer" in step:
            step["id"] = f"q{number}"
            self.answers[step["id"]] = step.pop("answer")
        if "fallback" in step:
            step["fallback"] = [self._other(other, loops) for other in step["fallback"]]
        if "parallel" in step:
            step["parallel"] = self.all(step["parallel"], loops)
        if "foreach" in step:
            self._loop(step, number, loops)
        elif "steps" in step:
            step["steps"] = self.all(step["steps"], loops)
        return step

    def _other(self, other, loops):
        return self.all(other, loops) if isinstance(other, list) else self.one(other, loops)

    def _act(self, step, number, loops):
        step["id"] = f"s{number}"
        step["with"]["name"] = "-".join([f"n{number}", *(f"${{{{ {name} }}}}" for name in loops)])
        if step["do"].endswith("set"):
            step["with"]["to"] = number
        if step.get("on_unknown") == "ask" and not self.sturdy:
            self.answers[step["id"]] = ["repeat", "skip", "stop", "repeat"][number % 4]
        else:
            self.answers[step["id"]] = "repeat"
        if self.sturdy:
            step.pop("on_unknown", None)
            step["retry"] = STURDY

    def _loop(self, step, number, loops):
        name = f"i{number}"
        step["id"] = f"l{number}"
        step["foreach"] = {name: step["foreach"]}
        step["steps"] = self.all(step["steps"], (*loops, name))
        has_aside = any(s.get("mode") for s in walk(step["steps"]))
        columns = {name: f"${{{{ {name} }}}}"} | ({} if has_aside else {"v": "${{ v }}"})
        named = [s["id"] for s in step["steps"] if "do" in s and not s["do"].endswith("set")]
        columns |= {f"c{i}": f"${{{{ steps.{i}.name }}}}" for i in named}
        step["collect"] = {f"{key}_{name}" if key == "v" else key: c for key, c in columns.items()}


def walk(steps):
    """Every step inside these steps."""
    for step in steps:
        yield step
        yield from walk(step.get("steps", []))
        yield from walk(step.get("parallel", []))
        for other in step.get("fallback", []):
            yield from walk(other if isinstance(other, list) else [other])


def hides(steps, *phases):
    """Whether a shot may come before one that is older in the text, or not at all."""
    shoots = any(step["do"].endswith("shoot") for phase in phases for step in phase)
    return shoots or any(s.get("mode") or s.get("on_failure") for s in walk(steps))


def named(steps, final, resume, *, sturdy=False):
    """A whole protocol, and the answers that a person gives to its questions.

    A probe proves nothing while a device has never fired. Where it depends on the crashes when that
    is, both devices fire first.
    """
    namer = Namer(sturdy=sturdy)
    prime = [do(d, "shoot", FINE, None) for d in "ab"] if hides(steps, final, resume) else []
    protocol = {"steps": [{"set": {"v": 0}}, *namer.all([*prime, *steps])]}
    protocol |= {"finally": namer.all(final)} if final else {}
    protocol |= {"on_resume": namer.all(resume)} if resume else {}
    return protocol, namer.answers
