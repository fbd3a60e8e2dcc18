"""Single steps and sets of them, as the strategies draw them; what is drawn has no names yet."""

import copy

from crashes_naming import STURDY
from hypothesis import strategies as st

FINE = ("ok", 0, 0)
NEVER = ("Broken", 99, 0)
FAULTS = [("Broken", 1, 0), ("Broken", 2, 0), NEVER, ("Broken", 0, 1)]
FAILS_AT_FIRST = [("Broken", 1, 0), ("Broken", 2, 0)]
UNKNOWN = [("happened!", 1, 0), ("dark", 1, 0)]
SHOT_FAULTS = [*FAULTS, ("Half", 1, 0), ("Half", 99, 0), *UNKNOWN]
DEATHS = [("die+", 1, 0), ("die-", 1, 0)]

retries = st.sampled_from([None, None, 2, 3, {"attempts": 2, "on": ["Half", "Broken"]}])
devices = st.sampled_from("ab")
policies = st.sampled_from([None, None, None, "ask", "skip", "repeat"])
holds = st.sampled_from(["${{ v > 0 }}", "${{ v < 2 }}", "${{ v > 1 }}"])


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


def on(device, step):
    """The same action, requested of this device."""
    return {**step, "do": device + step["do"][1:]}


def used(steps, last, twice, renamed, back=(), **said):
    """A used protocol; `back`: its `on_resume`."""
    other = without_none(steps=steps, on_resume=list(back) or None) | {"finally": last}
    return without_none(use=other, twice=twice, renamed=renamed, **said)


def surely(step):
    """The same action, whose failure goes up: an action that cannot fail needs no alternative."""
    return {key: value for key, value in step.items() if key != "on_error"}


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
actions = sets | shots | shots | looks
counted = st.sampled_from(
    [
        {"set": {"v": "${{ v + 1 }}"}},
        {"set": {"v": "${{ v + (1 if now() - elapsed() < now() else 100) }}"}},
    ]
)
instants = st.sampled_from(
    [
        {"log": "on"},
        {"wait": "3 ms"},
        {"wait": {"until": "${{ now() + 3 ms }}"}},
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

# --- iterations at once, whose reserved groups take turns; groups aside; watches

fine = st.builds(
    do, devices, st.sampled_from(["set", "look", "shoot", "shoot"]), st.just(FINE), ms=quick
)


def reserved(steps):
    """A group that has every device that it uses for itself."""
    return {"reserve": sorted({step["do"][0] for step in steps}), "steps": steps}


own_devices = st.builds(reserved, st.lists(fine, min_size=1, max_size=3))
unset = fine.filter(lambda step: not step["do"].endswith("set"))
calm_use = st.builds(
    lambda steps, last: used(steps, last, False, False),
    st.lists(unset, min_size=1, max_size=2), st.lists(unset, max_size=1),
)  # fmt: skip
overlapped = st.builds(
    lambda first, rest, count, at_once, order: {
        "foreach": list(range(count)), "at_once": at_once, "order": order, "steps": [first, *rest],
    },
    own_devices, st.lists(own_devices | unset | calm_use, max_size=2), st.integers(2, 4), st.integers(2, 3),
    st.sampled_from(["listed", "shortest"]),
)  # fmt: skip
aside_group = st.builds(
    lambda steps: {"steps": steps, "mode": "background"},
    st.lists(unset | unset | calm_use, min_size=1, max_size=3),
)
taking_turns = st.builds(
    lambda one, two: {"parallel": [{"steps": [one]}, {"steps": [two]}]}, own_devices, own_devices
)


def with_watch(condition, then, steps):
    """What is right from the beginning, or never: nothing in the steps changes it."""
    return {"watch": [{"when": condition, "then": then}], "steps": steps}


watching = st.builds(
    with_watch,
    holds,
    st.lists(fine | calm_use, min_size=1, max_size=3),
    st.lists(fine | calm_use, min_size=1, max_size=3),
)


# --- fallbacks

asks = st.builds(
    lambda choice: {"ask": "what now?", "choices": ["repeat", "skip", "stop"], "answer": choice},
    st.sampled_from(["skip", "skip", "stop"]),
)


def with_fallback(step, alternatives):
    return {**surely(step), "fallback": alternatives}


def repeated(step):
    """A step that fails in its first turn, so that a person's `repeat` helps."""
    step = copy.deepcopy(step)
    step["with"] |= {"word": "Broken", "tries": 0, "turns": 1}
    ask = {"ask": "again?", "choices": ["repeat", "skip", "stop"], "answer": "repeat"}
    return with_fallback(step, [ask])


sure = actions.map(surely)
others = st.lists(sure | st.lists(sure, min_size=1, max_size=2), min_size=1, max_size=2)
fallen = (
    st.builds(with_fallback, actions, others)
    | st.builds(with_fallback, shots, st.builds(lambda ask: [ask], asks))
    | st.builds(repeated, sets | shots)
)

# --- sets: one member for each device

known = sets | looks | shots.filter(lambda s: s.get("on_unknown") is None)
in_a_row = st.lists(known.map(surely), min_size=1, max_size=2)
together = st.builds(
    lambda one, two, retry: without_none(parallel=[on("a", one), on("b", two)], retry=retry),
    known, known, st.sampled_from([None, None, 2]),
) | st.builds(
    lambda one, two: {"parallel": [{"steps": [on("a", s) for s in one]}, on("b", two)]},
    in_a_row, known,
)  # fmt: skip
cancelling = st.builds(
    lambda bad, good: {"parallel": [on("a", bad), on("b", good)], "on_failure": "cancel"},
    st.builds(do, devices, st.sampled_from(["set", "look"]), st.sampled_from(FAULTS), ms=quick),
    st.builds(
        do, devices, st.sampled_from(["set", "look", "shoot", "shoot"]), st.just(FINE), ms=quick
    ),
)  # fmt: skip
calming = st.builds(do, devices, st.sampled_from(["set", "look"]), st.just(FINE))
tidying = st.builds(
    do, devices, st.just("shoot"), often(FINE, st.sampled_from(UNKNOWN)), st.just(3), ms=quick
)  # fmt: skip
finals = st.lists(calming | tidying, max_size=2)
backs = often([], st.lists(calming, min_size=1, max_size=2))
"""Of a used protocol: what it does before it goes on after a crash."""


def racing(*scripts):
    return st.builds(
        do, devices, st.sampled_from(["set", "look", "shoot", "shoot"]), st.sampled_from(scripts),
        ms=quick,
    )  # fmt: skip


def racer(device, steps, last):
    """A member of a race: one action, several in a row, or a used protocol with its `finally`."""
    steps = [on(device, step) for step in steps]
    if last is not None:
        last = [on(device, step) for step in last]
        return {"steps": [used(steps, last, False, False)]}
    return steps[0] if len(steps) == 1 else {"steps": steps}


lasts = st.none() | st.none() | st.lists(calming | tidying, min_size=1, max_size=1)


def races(*scripts):
    return st.builds(
        lambda one, two, last_a, last_b, retry: without_none(
            any=[racer("a", one, last_a), racer("b", two, last_b)], retry=retry
        ),
        st.lists(racing(*scripts), min_size=1, max_size=2),
        st.lists(racing(*scripts), min_size=1, max_size=2),
        lasts, lasts, st.sampled_from([None, None, 2]),
    )  # fmt: skip


race = races(FINE, FINE, NEVER, ("Broken", 0, 1))


def endless(steps, last, other):
    """Steps that never end by themselves, so they are stopped when they time out."""
    steps = [*steps, {"wait": "30 s"}]
    step = {"steps": steps} if last is None else used(steps, last, False, False)
    step["timeout"] = "0.3 s"
    if other is None:
        return {**step, "on_error": "continue"}
    return {"steps": [step], "fallback": [other]}


too_long = st.builds(
    endless, st.lists(racing(FINE), min_size=1, max_size=2), lasts, st.none() | sure
)  # fmt: skip
