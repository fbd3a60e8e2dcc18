"""How long a retry waits, and what it may try again."""

from labrun.engine.tree.nodes.failure import Failure
from labrun.engine.tree.nodes.retry import RetryRules


def test_pauses_grow_by_their_factor_up_to_their_limit():
    rules = RetryRules(5, wait_s=2.0, factor=3.0, max_wait_s=20.0)

    assert [rules.pause_s(n) for n in (1, 2, 3, 4)] == [2.0, 6.0, 18.0, 20.0]
    assert RetryRules(5).pause_s(1) == 0


def test_jitter_makes_a_pause_shorter_as_well_as_longer_within_its_share():
    rules = RetryRules(5, wait_s=10.0, jitter=0.2)
    pauses = [rules.pause_s(1) for _ in range(500)]

    assert 8.0 <= min(pauses) < 9.5
    assert 10.5 < max(pauses) <= 12.0


def test_what_may_be_done_twice_is_tried_again_although_nobody_knows_whether_it_happened():
    assert RetryRules(2).allows(Failure("Foggy", "", happened="unknown", once=False))
    assert not RetryRules(2).allows(Failure("Foggy", "", happened="unknown", once=True))


def test_a_once_action_that_happened_is_tried_again_only_if_its_error_is_named():
    half = Failure("Half", "", happened="yes", once=True)

    assert not RetryRules(2).allows(half)
    assert RetryRules(2, on=frozenset({"Half"})).allows(half)
    assert not RetryRules(2, on=frozenset({"Broken"})).allows(half)


def test_neither_a_skip_nor_a_stop_is_tried_again():
    assert not RetryRules(2).allows(Failure("Broken", "", skip=True))
    assert not RetryRules(2).allows(Failure("Broken", "", stop=True))


def test_the_first_turn_of_a_retried_group_has_plain_ids_and_each_later_one_its_own(own_device):
    ran = own_device().run("""
steps:
  - id: group
    retry: 3
    steps: [{id: x, do: a.act, with: {name: x, script: "Broken,Broken,ok"}}]
""")

    assert ran.status == 0
    assert [r.id.partition("/")[2] for r in ran.records if r.kind == "goal"] == [
        "main/group/x/1",
        "main/group/r2/group/x/1",
        "main/group/r3/group/x/1",
    ]
