"""Loops in words: over what, how often, what a failure causes, what is kept for each turn."""

import re
from collections.abc import Sequence
from typing import Any

from ....schemas import protocol as p
from ...language.grid import Grid, Span
from ...language.shape import Place
from ...language.table import Table
from ..english import bare, count_of, joined, shortened
from ..forecast import Outlook
from .speak import condition, said, spoken

FEW = 8
TABLE = re.compile(r"""csv\(\s*['"]([^'"]+)['"].*\)""", re.DOTALL)


def loop_words(view: Outlook, step: p.LoopBase, place: Place) -> str:
    """As `_each`, and how many of them run at the same time."""
    text = _each(view, step, place)
    if not isinstance(step, p.Foreach) or step.at_once is None:
        return text
    order = ", in the order that takes the least time" if step.order == "shortest" else ""
    return f"{text}, {spoken(view, step.at_once, (*place, 'at_once'))} at the same time{order}"


def _each(view: Outlook, step: p.LoopBase, place: Place) -> str:
    """`At each of 1,071 points of a 21 x 51 grid (snake), x from 0 mm to 4 mm ...`."""
    if isinstance(step, p.Foreach):
        name, raw = next(iter(step.foreach.items()))
        items = view.items(step, place)
        if items is None:
            return f"For each {name} of {spoken(view, raw, (*place, 'foreach', name))}"
        table = TABLE.fullmatch(bare(raw)) if isinstance(items, Table) else None
        if table is not None:
            return f"For each {name} of {table[1]} ({count_of(len(items), 'row')})"
        return _items_words(name, items)
    if isinstance(step, p.Repeat):
        times = view.number(step.repeat, (*place, "repeat"))
        told = spoken(view, step.repeat, (*place, "repeat"))
        return f"{count_of(times, 'time') if times is not None else f'{told} times'}, one after the other"
    assert isinstance(step, p.While)
    most = "" if step.max is None else f", {spoken(view, step.max, (*place, 'max'))} times at most"
    asked = condition(view.forgetting(step.steps), step.while_, (*place, "while"))
    return f"As long as {asked}{most}"


def _items_words(name: str, items: Sequence[Any]) -> str:
    if isinstance(items, Grid):
        size = f"{items.across:,} x {items.down:,}"
        return (
            f"At each of {count_of(len(items), name)} of a {size} grid ({items.order}; "
            f"x {_axis(items.x)}, y {_axis(items.y)})"
        )
    if isinstance(items, Span):
        return f"For each {name} {_axis(items)} ({count_of(len(items), 'value')})"
    if 0 < len(items) <= FEW:
        listed = joined(f"({said(one)})" if isinstance(one, dict) else said(one) for one in items)
        if len(listed) <= 120:
            return f"For each {name} of {listed}"
    return f"For each of {count_of(len(items), name)}"


def _axis(values: Sequence[Any]) -> str:
    """`from 0 mm to 4 mm in steps of 0.2 mm`."""
    first, last = said(values[0]), said(values[len(values) - 1])
    if len(values) == 1:
        return f"= {first}"
    if isinstance(values, Span):
        step = f"{values.step:.6g}" + (f" {values.unit}" if values.unit else "")
        if values.unit is not None:
            step = said(values[1] - values[0])
        return f"from {first} to {last} in steps of {step}"
    if len(values) <= FEW:
        return f"= {joined(said(one) for one in values)}"
    return f"from {first} to {last}, {len(values):,} values"


def loop_ending(view: Outlook, step: p.LoopBase, place: Place) -> str:
    """What failures of turns do, and the row that is kept for each."""
    name = next(iter(step.foreach)) if isinstance(step, p.Foreach) else "turn"
    name = name if len(name) > 1 else "turn"
    parts = []
    if step.keep_going is not None:
        limits = " or ".join(
            f"more than {spoken(view, limit, (*place, 'keep_going', key))} {words}"
            for key, limit, words in (
                ("max_failed", step.keep_going.max_failed, "of them"),
                ("in_a_row", step.keep_going.in_a_row, "in a row"),
            )
            if limit is not None
        )
        ends = f"with {limits} the step fails" if limits else "the step fails only if all do"
        parts.append(f"A {name} that fails for good is left out; {ends}.")
    if isinstance(step, p.While) and step.max is not None:
        parts.append("If that still holds afterwards, the step fails (MaxReached).")
    if step.collect:
        parts.append(f"For each {name} a row is kept: {shortened(', '.join(step.collect), 200)}.")
    return " ".join(parts)
