"""The order of iterations at once against all orders of a few, in a schedule written anew."""

from itertools import permutations
from random import Random
from statistics import median

from hypothesis import given
from hypothesis import strategies as st

from labrun.engine.run.shortest import lasts_s, shortest

DEVICES = [frozenset(name) for name in ("a", "b", "c", "ab")] + [frozenset[str]()]
legs = st.lists(st.tuples(st.sampled_from(DEVICES), st.integers(0, 9)), max_size=4)


def stepwise(jobs, at_once):
    """The same schedule second by second: who has waited longest for its devices goes first."""
    now, waiting, running, begun, asked = 0, [], [], 0, 0
    free = dict.fromkeys("abc", 0)
    while True:
        for job in [one for one in running if one[0] <= now]:
            running.remove(job)
            waiting.append((asked := asked + 1, job[1], job[2] + 1))
        for one in sorted(waiting):
            if one[2] == len(jobs[one[1]]):
                waiting.remove(one)
        while begun < len(jobs) and len(waiting) + len(running) < at_once:
            waiting.append((asked := asked + 1, begun, 0))
            begun += 1
        if not waiting and not running:
            return now
        blocked = set()
        for one in sorted(waiting):
            if one[2] == len(jobs[one[1]]):
                break
            devices, took = jobs[one[1]][one[2]]
            if not devices & blocked and all(free[device] <= now for device in devices):
                waiting.remove(one)
                running.append((now + took, one[1], one[2]))
                free.update(dict.fromkeys(devices, now + took))
            blocked |= devices
        if not any(at <= now for at, _, _ in running) and all(
            one[2] < len(jobs[one[1]]) for one in waiting
        ):
            now += 1


def drawn(random):
    return [[(frozenset(name), random.randint(1, 10)) for name in "abc"] for _ in range(5)]


@given(st.lists(legs, max_size=6), st.integers(1, 4))
def test_it_is_an_order_and_never_longer_than_the_listed_one(jobs, at_once):
    order = shortest(jobs, at_once)

    assert sorted(order) == list(range(len(jobs)))
    assert lasts_s([jobs[n] for n in order], at_once) <= lasts_s(jobs, at_once)


def test_the_schedule_is_that_of_first_come_first_served():
    random = Random(3)
    for _ in range(50):
        jobs = drawn(random)
        assert lasts_s(jobs, 3) == stepwise(jobs, 3)


def test_it_is_near_the_best_of_all_orders():
    random, over = Random(1), []
    for _ in range(30):
        jobs = drawn(random)
        best = min(lasts_s(order, 5) for order in permutations(jobs))
        over.append(lasts_s([jobs[n] for n in shortest(jobs, 5)], 5) / best)

    assert median(over) < 1.02
    assert max(over) < 1.15


def test_as_listed_where_nothing_is_gained():
    assert shortest([[(DEVICES[0], 5.0)]] * 3, 2) == [0, 1, 2]
    assert shortest([[(DEVICES[0], 3.0)], [(DEVICES[0], 5.0)], [(DEVICES[0], 4.0)]], 3) == [0, 1, 2]
    assert shortest([], 2) == []
