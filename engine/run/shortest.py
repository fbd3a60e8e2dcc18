"""In which order iterations at once take the least time, as far as the durations of their actions are known.

Each is a series of legs: devices, and for how long. They are put one after the other where they lengthen the
whole least, those with most to do first (the heuristic of Nawaz, Enscore and Ham, 1983); each trial is the
schedule that follows when whoever asks first for a device has it first. Only a few at a time are put in
order: none is passed by all the others, and the effort grows with their number alone.
"""

from collections.abc import Sequence
from heapq import heappop, heappush

FEW = 24
"""So many iterations are put in order at a time."""
LEGS = 600
"""So many legs at most are put in order at a time: that takes about 0.1 s."""

Leg = tuple[frozenset[str], float]
"""The devices that are busy, and for how many seconds."""


def shortest(jobs: Sequence[Sequence[Leg]], at_once: int) -> list[int]:
    """The order of the jobs that takes the least time of those tried; as listed, if none takes less."""
    listed = list(range(len(jobs)))
    if len({tuple(job) for job in jobs}) < 2:
        return listed
    order: list[int] = []
    for job in sorted(listed, key=lambda n: (-sum(took for _, took in jobs[n]), n)):
        trials = ([*order[:at], job, *order[at:]] for at in range(len(order) + 1))
        order = min(trials, key=lambda trial: lasts_s([jobs[n] for n in trial], at_once))
    return min((listed, order), key=lambda trial: lasts_s([jobs[n] for n in trial], at_once))


def lasts_s(jobs: Sequence[Sequence[Leg]], at_once: int) -> float:
    """How long they take together, if each device is for whoever asks first."""
    free: dict[str, float] = {}
    asks: list[tuple[float, int, int, int]] = []  # when, place in the order of asking, job, leg
    begun = min(at_once, len(jobs))
    for job in range(begun):
        heappush(asks, (0.0, job, job, 0))
    asked, last_s = begun, 0.0
    while asks:
        now_s, _, job, leg = heappop(asks)
        if leg == len(jobs[job]):
            last_s = max(last_s, now_s)
            if begun == len(jobs):
                continue
            job, leg, begun = begun, 0, begun + 1
        else:
            devices, took_s = jobs[job][leg]
            now_s = max(now_s, *(free.get(device, 0.0) for device in devices), 0.0) + took_s
            for device in devices:
                free[device] = now_s
            leg += 1
        asked += 1
        heappush(asks, (now_s, asked, job, leg))
    return last_s
