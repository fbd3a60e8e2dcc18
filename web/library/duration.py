"""How often each action of a protocol happens, and how long that takes in all."""

from collections.abc import Iterator
from math import inf

from ...engine.lab.bind import BoundRole
from ...engine.language.shape import Place
from ...engine.views.count import RunCounts
from ...engine.views.forecast import Outlook
from ...schemas import protocol as p
from ...schemas.lab import Lab
from ...schemas.quantity import is_number, seconds
from ..models.protocols import SpanS
from .timings import Spread, Timings


def actions_of(view: Outlook, found: RunCounts) -> dict[str, int | None]:
    """`device.action` -> how often if nothing fails; None if known only during the run."""
    counts: dict[str, int | None] = {}
    for place, _, bound, name in _actions(view):
        times = found.times.get(place)
        label = f"{bound.device}.{name}"
        before = counts.get(label, 0)
        most = times.most if times is not None else 0
        counts[label] = None if before is None or most is None else before + most
    return counts


def time_of(view: Outlook, found: RunCounts, timings: Timings, lab: Lab | None) -> SpanS | None:
    """Seconds from first to last action; a set counts as long as its longest member.

    Measured in earlier runs if there are any, else from the contracts, with twins as quick as the
    lab says; None if a loop's length is known only during the run or an action's duration is
    unknown.
    """
    low = high = real = 0.0
    runs: list[int] = []
    quicker = False
    sets: dict[Place, tuple[float, ...]] = {}
    for place, step, bound, name in _actions(view):
        times = found.times.get(place)
        if times is None or times.most == 0 or step.mode == "background":
            continue
        spread = _spread(bound, name, timings, lab)
        if times.most is None or spread is None:
            return None
        runs.append(spread.runs)
        speed, said = _speed(lab, bound.device), bound.contract.actions[name].duration
        quicker = quicker or speed != 1.0
        typical = seconds(said) if said is not None else spread.typical
        took = (spread.low * times.most, spread.high * times.most, typical * times.most)
        around = _set_around(place)
        if around is None:
            low, high, real = low + took[0], high + took[1], real + took[2]
        else:
            before = sets.get(around, (0.0, 0.0, 0.0))
            sets[around] = tuple(map(max, before, took))
    if not runs:
        return None
    low += sum(one[0] for one in sets.values())
    high += sum(one[1] for one in sets.values())
    real += sum(one[2] for one in sets.values())
    return SpanS(low=low, high=high, runs=min(runs), real_s=real if quicker else None)


def _set_around(place: Place) -> Place | None:
    """The outermost set that contains a step, directly or indirectly."""
    for index, part in enumerate(place):
        if part in ("parallel", "any"):
            return place[:index]
    return None


def _spread(bound: BoundRole, name: str, timings: Timings, lab: Lab | None) -> Spread | None:
    """Duration measured in runs, else the contract's."""
    known = timings.spread(f"{bound.device}.{name}")
    said = bound.contract.actions[name].duration
    if known is not None or said is None:
        return known
    typical = seconds(said) / _speed(lab, bound.device)
    return Spread(typical, typical, typical, 0)


def _speed(lab: Lab | None, device: str) -> float:
    """How many times faster than real a twin's clock runs; one that only counts is not slow."""
    clock = lab.devices[device].config.get("clock") if lab is not None and lab.simulated else None
    if is_number(clock) and clock > 0:
        return float(clock)
    return inf if clock == "fast" else 1.0


def _actions(view: Outlook) -> Iterator[tuple[Place, p.Do, BoundRole, str]]:
    """Every action of the protocol and of those it uses, with its place in the tally."""
    for at in view.survey.steps:
        if at.place[0] != "steps" and not view.within:
            continue
        if isinstance(at.step, p.Do):
            role, _, name = at.step.do.partition(".")
            bound = view.roles.get(role)
            if bound is not None and name in bound.contract.actions:
                yield (*view.within, *at.place), at.step, bound, name
        elif isinstance(at.step, p.Use):
            other = view.used(at.step, at.place)
            if other is not None:
                yield from _actions(other)
