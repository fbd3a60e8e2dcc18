"""The steps of a protocol as numbered sentences."""

from collections.abc import Iterator, Sequence
from typing import Any

from ....schemas import protocol as p
from ...language.shape import Place
from ...language.value import CLOSE, OPEN
from ..english import bare, joined, lower_first, upper_first
from ..forecast import UNKNOWN, Outlook
from .act import action_sentence
from .failing import last_sentences, limit_text, retry_sentence
from .item import Item
from .loops import loop_ending, loop_words
from .speak import condition, spoken


def sentences(view: Outlook, steps: Sequence[Any], place: Place) -> list[Item]:
    """One item per step, in order."""
    return [step_item(before, step, here) for before, step, here in view.along(steps, place)]


def step_item(view: Outlook, step: Any, place: Place) -> Item:
    """One step: what is done, then what happens if it fails."""
    item = _kind(view, step, place)
    guard = _guard(view, step, place)
    if guard:
        item.text = (
            guard + lower_first(item.text) if item.text.startswith("The ") else guard + item.text
        )
    failing = _failing(view, step, place)
    if item.below:
        item.after = " ".join(part for part in (item.after, failing) if part)
    else:
        item.text = " ".join(part for part in (item.text, failing) if part)
    return item


def _guard(view: Outlook, step: p.StepBase, place: Place) -> str:
    if step.when is None or view.truth(step.when, (*place, "when")) is True:
        return ""
    asked = condition(view, step.when, (*place, "when"))
    if view.truth(step.when, (*place, "when")) is False:
        return f"Left out with these parameters (only if {asked}): "
    return f"Only if {asked}: "


def _failing(view: Outlook, step: p.StepBase, place: Place) -> str:
    said = step.retry
    if said is None and isinstance(step, p.Do):
        said = view.protocol.defaults.retry
    whole = isinstance(step, p.Parallel | p.AnyOf)
    parts = [retry_sentence(said, "each of them that failed" if whole else "it")]
    later = view.forgetting([step])  # what it has set by then is not known
    if step.fallback:
        parts.append(_fallback(later, step, place))
    parts += [
        _watch(later, (*place, "watch", number), watch)
        for number, watch in enumerate(p.watches(step))
    ]
    parts += last_sentences(step)
    return " ".join(part for part in parts if part)


def _watch(view: Outlook, place: Place, watch: p.Watch) -> str:
    """`As soon as ..., the steps are cancelled: ...`"""
    asked = condition(view, watch.when, (*place, "when"))
    read = f" ({'; '.join(_looking(watch))})"
    if watch.then == "pause":
        return f"As soon as {asked}{read}, the run is paused."
    at, single = (*place, "then"), not isinstance(watch.then, list)
    then = one_sentence(view, watch.steps, at, single=single)
    stops = "" if watch.leaves_running else "they are cancelled, and then "
    return f"As soon as {asked}{read}, {stops}{then}."


def _looking(watch: p.Watch) -> Iterator[str]:
    if watch.every is not None:
        looked = "looked at" if watch.do is None else f"{watch.do} is read"
        yield f"{looked} every {bare(watch.every)}"
    if watch.on_stale == "ignore":
        yield "not if that is unknown"
    elif watch.stale is not None:
        yield f"also if that is unknown for {bare(watch.stale)}"
    else:
        yield (
            "also if that is unknown for three times that"
            if watch.every
            else "also if unknown for 5 s"
        )


def _fallback(view: Outlook, step: p.StepBase, place: Place) -> str:
    """`If it still fails: ...; if that fails too: ...`"""
    said = []
    for index, one in enumerate(step.fallback):
        at = (*place, "fallback", index)
        if isinstance(one, list):
            words = one_sentence(view, one, at)
        else:
            name = f"{lower_first(one.name)}: " if one.name else ""
            words = name + one_sentence(view, [one], at, single=True)
        said.append(words)
    begin = "If it still fails, " if step.retry is not None else "If that fails, "
    return begin + "; if that fails too, ".join(said) + "."


def one_sentence(view: Outlook, steps: Sequence[Any], place: Place, *, single: bool = False) -> str:
    """Several steps as parts of one sentence."""
    parts = []
    for before, step, at in view.along(steps, place):
        here = place if single else at
        if isinstance(step, p.Group):
            parts.append(one_sentence(before, step.steps, (*here, "steps")))
        else:
            parts.append(_flat(step_item(before, step, here)))
    return ", then ".join(parts)


def _flat(item: Item) -> str:
    text = lower_first(item.text).rstrip(".")
    if not item.below:
        return text
    return f"{text.rstrip(':')} ({'; '.join(_flat(inner) for inner in item.below)})"


# --- one function per kind


def _kind(view: Outlook, step: Any, place: Place) -> Item:
    if isinstance(step, p.Do):
        aside = "; the next steps start meanwhile" if step.mode else ""
        return _item(action_sentence(view, step, place), limit_text(step) + aside)
    if isinstance(step, p.Parallel | p.AnyOf):
        return _set(view, step, place)
    if isinstance(step, p.LoopBase):
        inside = view.forgetting(step.steps)
        below = sentences(inside, step.steps, (*place, "steps"))
        return Item(
            loop_words(view, step, place) + limit_text(step) + ":",
            below,
            loop_ending(view, step, place),
        )
    if isinstance(step, p.If):
        return _if(view, step, place)
    if isinstance(step, p.Use):
        return _use(view, step, place)
    if isinstance(step, p.Group):
        name = upper_first(step.name) if step.name else "In order"
        if step.reserve:
            name += f", with the {joined(step.reserve, 'and')} to itself"
        name += ", while the next steps start" if step.mode else ""
        return Item(f"{name}{limit_text(step)}:", sentences(view, step.steps, (*place, "steps")))
    return _plain(view, step, place)


def _item(text: str, more: str = "") -> Item:
    return Item(f"{upper_first(text)}{more}.")


def _set(view: Outlook, step: p.Parallel | p.AnyOf, place: Place) -> Item:
    """In one sentence if the members are single actions that state nothing about failures."""
    members = getattr(step, step.KIND)
    places = [(*place, step.KIND, index) for index in range(len(members))]
    wins = isinstance(step, p.AnyOf)
    if all(_is_bare(member) for member in members):
        parts = [
            action_sentence(view, one, at) + limit_text(one)
            for one, at in zip(members, places, strict=True)
        ]
        text = (
            f"At the same time, {', '.join(parts[:-1])}, and {parts[-1]}"
            if len(parts) > 1
            else parts[0]
        )
        return _item(text, "; the first that succeeds ends the others" if wins else "")
    below = [step_item(view, one, at) for one, at in zip(members, places, strict=True)]
    end = " (the first that succeeds ends the others)" if wins else ""
    return Item(f"At the same time{end}{limit_text(step)}:", below)


def _is_bare(step: Any) -> bool:
    plain = (step.retry, step.when, step.on_error, step.on_unknown)
    return isinstance(step, p.Do) and not step.fallback and all(one is None for one in plain)


def _if(view: Outlook, step: p.If, place: Place) -> Item:
    truth = view.truth(step.if_, (*place, "if"))
    known = "" if truth is None else " (which is true)" if truth else " (which is false)"
    below = sentences(view, step.then, (*place, "then"))
    if step.else_:
        others = sentences(view, step.else_, (*place, "else"))
        below.append(Item("Otherwise:", others, numbered=False))
    asked = condition(view, step.if_, (*place, "if"))
    return Item(f"If {asked}{known}{limit_text(step)}:", below)


def _use(view: Outlook, step: p.Use, place: Place) -> Item:
    given = [f"{n} = {spoken(view, raw, (*place, 'with', n))}" for n, raw in step.with_.items()]
    other = view.used(step, place)
    name = f"{other.protocol.name!r} ({step.use})" if other is not None else step.use
    with_ = f" with {joined(given)}" if given else ""
    below = []
    if other is not None:
        below = sentences(other, other.protocol.steps, ("steps",))
        if other.protocol.on_resume:
            again = sentences(other, other.protocol.on_resume, ("on_resume",))
            below.append(Item("Before it is resumed after a stop:", again, numbered=False))
        if other.protocol.finally_:
            last = sentences(other, other.protocol.finally_, ("finally",))
            below.append(Item("At its end, whatever happened:", last, numbered=False))
    return Item(f"The protocol {name} is carried out{with_}{limit_text(step)}:", below)


def _plain(view: Outlook, step: Any, place: Place) -> Item:
    """Steps without a device."""
    if isinstance(step, p.Confirm):
        text = spoken(view, step.confirm, (*place, "confirm"))
        return _item(f"A person confirms: “{text}”", limit_text(step))
    if isinstance(step, p.Ask):
        text = spoken(view, step.ask, (*place, "ask"))
        return _item(
            f"A person is asked: “{text}” ({joined(step.choices, 'or')})", limit_text(step)
        )
    if isinstance(step, p.Wait) and step.until is not None:
        until = spoken(view, step.until, (*place, "wait", "until"))
        return _item(f"The protocol waits until {until}")
    if isinstance(step, p.Wait):
        return _item(f"The protocol waits {spoken(view, step.wait, (*place, 'wait'))}")
    if isinstance(step, p.Set):
        given = [f"{n} be {spoken(view, raw, (*place, 'set', n))}" for n, raw in step.set.items()]
        return _item(f"Let {joined(given)}")
    if isinstance(step, p.Require):
        asked = condition(view, step.require, (*place, "require"))
        return _item(f"The run continues only if {asked}")
    if isinstance(step, p.Log):
        return _item(f"It is noted: {_quoted(view, step.log, (*place, 'log'))}")
    if isinstance(step, p.Fail):
        return _item(f"This counts as a failure: {_quoted(view, step.fail, (*place, 'fail'))}")
    if isinstance(step, p.Notify):
        return _item(f"a message is sent: {_quoted(view, step.notify, (*place, 'notify'))}")
    return _item(f"{step.KIND}: {bare(getattr(step, step.KIND, ''))}")


def _quoted(view: Outlook, raw: str, place: Place) -> str:
    """A text in quotation marks; the words for it where all of it is computed in the run."""
    words = spoken(view, raw, place)
    whole = raw.count(OPEN) == 1 and raw.startswith(OPEN) and raw.endswith(CLOSE)
    return words if whole and view.value(raw, place) is UNKNOWN else f"“{words}”"
