"""What must hold after any number of crashes: the promise of the journal, as assertions."""

from collections import Counter
from itertools import pairwise


def shots(story):
    """What happened for good, in order."""
    return [line for line in story.happened if line["action"] == "shoot"]


def phase_of(shot):
    return shot["goal"].split("/")[1]


def in_main(story):
    return [shot for shot in shots(story) if phase_of(shot) == "main"]


def nothing_twice_and_nothing_lost(story, oracle, *, tries=0):
    """What the devices did for good is what a run without crashes does, equally often.

    A used protocol whose steps fail tidies up, each time that a person has the run go on.
    """
    done = Counter(shot["name"] for shot in in_main(story))
    spare = Counter(dict.fromkeys(oracle.tidy, tries))
    often, lost = done - oracle.happened - oracle.maybe - spare, oracle.happened - done
    undecided = [any_of for any_of in oracle.either if not any(done.keys() >= w for w in any_of)]
    goals = Counter(shot["goal"] for shot in shots(story))

    assert not often and not lost, f"too often: {often}, not: {lost}"
    assert not undecided, f"nobody has won: {undecided}"
    assert max(goals.values(), default=1) == 1, f"one goal happened twice: {goals}"


def in_focus(story, oracle, *, tries=0):
    """Every shot found its devices as in a run without crashes."""
    found = {}
    for shot in in_main(story):
        found.setdefault(shot["name"], []).append(shot["states"])
    for name in oracle.focus.keys() - oracle.maybe.keys() - (oracle.tidy if tries else set()):
        wanted = oracle.focus[name]
        for states, want in zip(found[name], wanted, strict=True):
            blurred = {d: states[d] for d in want if want[d] not in ("any", states[d])}

            assert not blurred, f"{name} fired at {blurred}, not at {want}"


def same_end(story, oracle, status):
    """The run ends as one without crashes, with the same rows and holes."""
    assert story.status == status, f"ended {story.exits}, not {status}"
    assert story.tables() == oracle.tables, f"rows {story.tables()}, not {oracle.tables}"
    assert story.records[-1].holes == oracle.holes


def journal_is_whole(story):
    """The chain holds, nothing was started unannounced, no goal was announced twice."""
    records = story.records  # reading them checks their hashes
    announced = Counter(record.id for record in records if record.kind == "goal")
    early = [line["goal"] for line in story.happened if not line["announced"]]
    unheard = [line["goal"] for line in story.happened if line["goal"] not in announced]

    assert records[-1].kind == "finished"
    assert [record.n for record in records] == list(range(1, len(records) + 1))
    assert not early and not unheard, f"begun before it was announced: {early + unheard}"
    assert max(announced.values(), default=1) == 1, f"announced twice: {announced}"


def finally_ran_last(story, protocol):
    """The last phase is `finally`, and its actions are the last that any device started."""
    phases = [record.phase for record in story.records if record.kind == "phase"]
    begun = [line["goal"].split("/")[1] for line in story.happened if line["action"] == "begin"]

    assert phases[-1].startswith("finally:" if protocol.get("finally") else ("main", "finally:"))
    assert not protocol.get("finally") or begun[-1] == phases[-1], begun


def tidied_once(story, protocol):
    """`finally` and `on_resume` fire once each time they run, and completely if they end."""
    fired = Counter((phase_of(shot), shot["name"]) for shot in shots(story))
    fired = Counter({key: count for key, count in fired.items() if key[0] != "main"})
    phases = [record.phase for record in story.records if record.kind == "phase"]
    over = [one for one, after in pairwise(phases) if after == "main"] + phases[-1:]
    wanted = Counter()
    for phase in over:
        steps = protocol.get("on_resume" if phase.startswith("resume") else "finally", [])
        fires = [step["with"]["name"] for step in steps if step["do"].endswith("shoot")]
        wanted |= Counter((phase, name) for name in fires if phase != "main")

    assert max(fired.values(), default=1) == 1, f"fired twice in one phase: {fired}"
    assert not wanted - fired, f"not fired: {wanted - fired}"


def kept(story, oracle, status, protocol, tries=0):
    """All of it."""
    nothing_twice_and_nothing_lost(story, oracle, tries=tries)
    in_focus(story, oracle, tries=tries)
    journal_is_whole(story)
    tidied_once(story, protocol)
    finally_ran_last(story, protocol)
    same_end(story, oracle, status)
