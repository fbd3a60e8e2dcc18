"""Random protocols, fault schedules and kill points, as the test draws them.

What is drawn has no names yet; `named` gives them in the order of the text, so that the same draw
is the same protocol.
"""

from crashes_draws import (
    FAILS_AT_FIRST,
    FINE,
    UNKNOWN,
    actions,
    aside,
    aside_group,
    backs,
    cancelling,
    counted,
    deadly,
    devices,
    do,
    fallen,
    finals,
    goes_on,
    holds,
    instants,
    often,
    overlapped,
    quick,
    race,
    races,
    sure,
    taking_turns,
    together,
    too_long,
    used,
    watching,
    without_none,
)
from crashes_naming import Namer, hides, patient
from hypothesis import strategies as st

__all__ = ["devices_are_touched", "engine_dies", "patient", "run_fails", "server_dies"]

again = st.sampled_from([None, None, 2])


def looped(steps, how, limit, retry):
    """A loop of any kind over these steps."""
    kind, count = how[0], how[1]
    kinds = {
        "foreach": {"foreach": list(range(count))},
        "repeat": {"repeat": count},
        "while": {"while": count, "max": max(1, count + 1 - how[2]), "counts_at": how[3]},
    }
    keeps = None if limit is None else {"max_failed": limit}
    return without_none(**kinds[kind], steps=steps, retry=retry, keep_going=keeps)


loops = st.tuples(
    st.sampled_from(["foreach", "foreach", "repeat", "while", "while"]), st.integers(1, 3),
    st.sampled_from([0, 0, 0, 2]), st.integers(0, 3),
)  # fmt: skip


def groups(inner):
    body = st.lists(inner, min_size=1, max_size=3)
    instead = st.lists(sure | together, min_size=1, max_size=3)
    asides = st.builds(lambda steps, step: [*steps, step], body, aside | aside | aside_group)
    group = st.builds(
        lambda steps, retry, on_error: without_none(steps=steps, retry=retry, on_error=on_error),
        body | body | asides, st.sampled_from([None, 2]), goes_on,
    )  # fmt: skip
    fallen_group = st.builds(
        lambda steps, retry, other: without_none(steps=steps, retry=retry, fallback=[other]),
        body, again, instead,
    )  # fmt: skip
    loop = st.builds(
        looped, body | asides, loops, st.sampled_from([None, 0, 1, 5]), again,
    )  # fmt: skip
    branch = st.builds(
        lambda condition, then, other, retry: without_none(
            **{"if": condition, "then": then, "else": other}, retry=retry
        ),
        holds, body | asides, st.none() | body, again,
    )  # fmt: skip
    other = st.builds(
        lambda steps, last, twice, renamed, back, retry, on_error: used(
            steps, last, twice, renamed, back, retry=retry, on_error=on_error
        ),
        body | asides, finals, often(False, st.booleans()), st.booleans(), backs, again, goes_on,
    )  # fmt: skip
    fallen_other = st.builds(
        lambda steps, last, other: used(steps, last, False, False, fallback=[other]),
        body, finals, instead,
    ) | st.builds(
        lambda steps, primary, last: without_none(
            **primary, fallback=[[used(steps, last, False, True)]]
        ),
        body, sure, finals,
    )  # fmt: skip
    return group | loop | loop | fallen_group | branch | other | other | fallen_other


leaves = (
    actions | actions | fallen | together | cancelling | counted | instants | race | too_long
    | overlapped | taking_turns | watching
)  # fmt: skip
calm = st.lists(st.recursive(leaves, groups, max_leaves=7), min_size=1, max_size=4)
rough = st.lists(
    st.recursive(leaves | deadly | deadly | deadly, groups, max_leaves=6),
    min_size=1, max_size=4,
)  # fmt: skip
stubborn = st.builds(
    do, devices, st.sampled_from(["set", "look"]), often(FINE, st.sampled_from(FAILS_AT_FIRST)),
    ms=quick,
) | st.builds(
    do, devices, st.just("shoot"), often(FINE, st.sampled_from([*FAILS_AT_FIRST, *UNKNOWN])),
    ms=quick,
)  # fmt: skip
WHENS = ["before", "torn", "after", "later"]


@st.composite
def kills(draw, *touches):
    """Up to three kills; the first cannot come before anything is on disk, since there is no run yet."""
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
    """The device server dies in the middle of its actions, the engine sometimes."""
    return crashes(rough, "", "restart", sturdy=True) | crashes(rough, "", sturdy=True)


def run_fails():
    """Nothing is retried automatically: the run fails, and is resumed by hand until it succeeds."""
    flat = st.lists(stubborn | races(FINE), min_size=1, max_size=3)
    loop = st.builds(looped, flat, loops, st.none(), st.none())
    other = st.builds(
        lambda steps, last, renamed: used(steps, last, False, renamed), flat, finals, st.booleans()
    )
    branch = st.builds(lambda c, then: {"if": c, "then": then}, holds, flat)
    steps = st.lists(stubborn | stubborn | loop | other | branch | counted, min_size=1, max_size=4)
    return crashes(steps, "", "stop", "restart")


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
