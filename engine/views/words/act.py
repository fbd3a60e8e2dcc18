"""One action as a sentence: who does what, from the contract's own words."""

import re

from ....schemas import protocol as p
from ....schemas.contract import Action
from ...lab.bind import BoundRole
from ...language.shape import Place
from ..english import joined, lower_first, third_person
from ..forecast import Outlook
from .speak import spoken
from .verbs import VERBS

PREPOSITIONS = (
    "to", "by", "at", "for", "from", "into", "onto", "in", "on", "with", "up", "down", "off",
)  # fmt: skip
NOUN = re.compile(r"(the|a|an|what|where|which|how|whether|outlines?|list|number)\b", re.IGNORECASE)
CLAUSE = re.compile(r"(, and |, then |, | and | then )")


def subject(bound: BoundRole) -> str:
    """`the gantry` if the role has the name of its kind of device, else the role's name."""
    kind = bound.contract.type.partition("@")[0]
    return f"the {bound.role}" if bound.role == kind else bound.role


def action_sentence(view: Outlook, step: p.Do, place: Place) -> str:
    """`the gantry moves to z = 10 mm`, without what happens if it fails."""
    role, _, name = step.do.partition(".")
    if (found := view.survey.action(step)) is None:
        return f"{role} does {name}"
    bound, action = found
    given = {n: spoken(view, raw, (*place, "with", n)) for n, raw in step.with_.items()}
    return f"{subject(bound)} {predicate(name, action, given)}"


def predicate(name: str, action: Action, given: dict[str, str]) -> str:
    """What the device does: `moves to x = 4 mm`, `draws liquid into the tip (volume = 200 µL)`."""
    parts = name.strip("_").split("_")
    if given and len(parts) > 1 and parts[-1] in PREPOSITIONS and parts[0] in VERBS:
        return f"{third_person(parts[0])} {' '.join(parts[1:])} {_arguments(given)}"
    aside = f" ({_arguments(given)})" if given else ""
    return does(name, action) + aside


def does(name: str, action: Action) -> str:
    """The contract's summary as what the device does, or its name if the summary has no verb."""
    summary = re.split(r"[;:(]|\. ", action.summary)[0].strip().rstrip(".")
    first = summary.partition(" ")[0].lower()
    if first in VERBS:
        return conjugated(summary)
    parts = name.strip("_").split("_")
    if summary and NOUN.match(summary):
        return f"reports {lower_first(summary)}"
    verb = third_person(parts[0]) if len(parts) == 1 or parts[0] in VERBS else f"does {parts[0]}"
    own = " ".join([verb, *parts[1:]])
    return f"{own} ({lower_first(summary)})" if summary else own


def conjugated(summary: str) -> str:
    """`Purge with argon, fire one burst` as `purges with argon, fires one burst`."""
    pieces = CLAUSE.split(lower_first(summary))
    for index in range(0, len(pieces), 2):
        verb, space, rest = pieces[index].partition(" ")
        if verb in VERBS:
            pieces[index] = third_person(verb) + space + rest
    return "".join(pieces)


def _arguments(given: dict[str, str]) -> str:
    """`x = 4 mm and y = 2 mm`; of a point's own fields, `the point (x, y)`."""
    owners = {
        re.sub(r"'s \w+$", "", words) for n, words in given.items() if words.endswith(f"'s {n}")
    }
    own = all(words.endswith(f"'s {name}") for name, words in given.items())
    if own and len(owners) == 1 and len(given) > 1:
        return f"{owners.pop()} ({', '.join(given)})"
    return joined(
        words if words == f"the {name}" else f"{name} = {words}" for name, words in given.items()
    )
