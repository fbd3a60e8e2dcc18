"""The kills of a tortured run: what each one hits, and when."""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import Literal, get_args

Whom = Literal[
    "engine", "engine and servers", "servers", "abort", "servers end", "servers stop", "ledgers"
]
Form = Literal["before", "torn", "after"]

FORMS: tuple[Form, ...] = get_args(Form)
EARLY_S, LATE_S = 0.1, 3.5
WRITES = 80
"""A session is killed within this many seconds or journal writes, or within those of a whole run."""


@dataclass(frozen=True, slots=True)
class Kill:
    """One kill of one engine session.

    It comes `after_s` seconds after the engine's start, or at the engine's `flush`-th write to its
    journal: before it, with half of it on disk, or when it is on disk and nothing has followed.
    """

    whom: Whom
    after_s: float | None = None
    flush: int = 0
    form: Form = "after"

    @property
    def label(self) -> str:
        """Its name in the table."""
        if self.whom in OTHERS:
            return OTHERS[self.whom]
        when = "at a random moment" if self.after_s is not None else f"journal: {WORDS[self.form]}"
        return f"{self.whom}, {when}"


STOPPED_S = 3.0
"""How long servers are stopped by SIGSTOP."""
OTHERS: dict[Whom, str] = {
    "abort": "aborted (SIGTERM), resumed",
    "servers end": "servers, ended in order (SIGTERM)",
    "servers stop": f"servers, stopped for {STOPPED_S:g} s (SIGSTOP)",
    "ledgers": "engine and servers, then an older ledger or none",
}
SHARES: dict[Whom, int] = {
    "engine": 8, "engine and servers": 6, "servers": 6, **dict.fromkeys(OTHERS, 2)
}  # fmt: skip
"""How often each comes."""
WORDS = {"before": "before a write", "torn": "half of a write", "after": "after a write"}


def at_random(random: Random, lasts_s: float, writes: int) -> Iterator[Kill]:
    """Kills without end: half of them at any moment, half at a journal write.

    `lasts_s` and `writes` are those of an undisturbed run.
    """
    while True:
        whom = random.choices(list(SHARES), list(SHARES.values()))[0]
        if whom == "servers" or whom in OTHERS or random.random() < 0.5:
            yield Kill(whom, after_s=random.uniform(EARLY_S, min(LATE_S, lasts_s)))
        else:
            flush, form = random.randint(1, min(WRITES, writes)), random.choice(FORMS)
            yield Kill(whom, flush=flush, form=form)


def at_boundary(flush: int, seed: int) -> Kill:
    """The kill at one journal write; the kinds alternate, differently for each seed."""
    kinds: list[tuple[Whom, Form]] = [
        (whom, form) for form in FORMS for whom in ("engine", "engine and servers")
    ]
    whom, form = kinds[(flush + seed) % len(kinds)]
    return Kill(whom, flush=flush, form=form)
