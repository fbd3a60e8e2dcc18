"""The same seed plans the same kills, of every kind."""

from itertools import islice
from random import Random
from typing import get_args

from labrun.engine.torture.plan import Whom, at_boundary, at_random


def planned(seed, count=300):
    return list(islice(at_random(Random(seed), lasts_s=60, writes=500), count))


def test_a_seed_is_a_plan():
    assert planned(1) == planned(1)
    assert planned(1) != planned(2)


def test_every_kind_of_blow_is_planned():
    kills = planned(3)

    assert {kill.whom for kill in kills} == {*get_args(Whom)}
    assert {kill.form for kill in kills if kill.flush} == {"before", "torn", "after"}


def test_kills_come_within_a_short_run():
    kills = islice(at_random(Random(1), lasts_s=0.5, writes=4), 200)

    assert all((kill.after_s or 0) <= 0.5 and kill.flush <= 4 for kill in kills)


def test_boundaries_take_turns_and_each_seed_has_its_own():
    kinds = [(kill.whom, kill.form) for kill in (at_boundary(n, 1) for n in range(1, 7))]

    assert len(set(kinds)) == 6
    assert at_boundary(1, 1) != at_boundary(1, 2)
