"""A rehearsal as a person reads it."""

from collections.abc import Iterator

from .tally import Tally

SHOWN = 12


def lines(tally: Tally, real_s: float) -> Iterator[str]:
    """Line by line: the whole, the parts, the work, and what would go wrong."""
    yield f"The run takes {duration(tally.lasts_s)} and {_ends(tally)}. (Rehearsed in {real_s:.1f} s.)"
    yield ""
    yield from _parts(tally)
    yield ""
    yield from _work(tally)
    yield ""
    yield from _wrong(tally)
    strange = [f"{d} is played by {who}" for d, who in tally.players.items() if "stand-in" in who]
    if strange:
        yield ""
        yield "; ".join(strange) + ": typical times and the plainest answers, no faults of its own."


def _ends(tally: Tally) -> str:
    holes = f" with {_count(tally.holes, 'hole')}" if tally.holes else ""
    reason = f": {tally.reason}" if tally.reason else ""
    return f"{tally.fate}{holes}{reason}"


def _parts(tally: Tally) -> Iterator[str]:
    width = max([len(part.name) for part in tally.parts] or [4])
    yield f"{'part':<{width}}  {'begins at':>10}  {'takes':>10}  {'a point':>9}  actions"
    for part in tally.parts:
        each = duration(part.takes_s / part.iterations) if part.iterations else ""
        yield (
            f"{part.name:<{width}}  {duration(part.begins_s):>10}  {duration(part.takes_s):>10}  "
            f"{each:>9}  {part.goals:,}" + (f" in {part.iterations:,} points" if each else "")
        )


def _work(tally: Tally) -> Iterator[str]:
    width = max([len(label) for label in tally.actions] or [6])
    yield f"{'action':<{width}}  {'times':>7}  {'in all':>10}"
    for label, count in tally.actions.items():
        once = "  once each: never repeated unasked" if tally.once.get(label) else ""
        yield f"{label:<{width}}  {count:>7,}  {duration(tally.seconds[label]):>10}{once}"
    for device, mm in tally.path_mm.items():
        yield f"{device} travels {mm / 1000:,.2f} m"


def _wrong(tally: Tally) -> Iterator[str]:
    clean = not (tally.troubles or tally.questions or tally.slow or tally.reason)
    if clean:
        yield "Nothing goes wrong. Order faults to see what would happen: --fail ROLE.ACTION:0.05"
        return
    yield "What goes wrong:"
    for trouble in tally.troubles[:SHOWN]:
        yield (
            f"  {trouble.action}: {trouble.error}, {_count(trouble.count, 'time')}, first after "
            f"{duration(trouble.first_at_s)} at {trouble.first_path}: {trouble.message}"
        )
    if tally.sent_again:
        yield f"  {_count(tally.sent_again, 'goal')} sent again by retry"
    if tally.holes:
        yield f"  {_count(tally.holes, 'point')} left as holes"
    for label, (took, limit) in tally.slow.items():
        yield f"  {label} took up to {duration(took)} of its timeout of {duration(limit)}"
    for text in tally.questions[:SHOWN]:
        yield f"  a person is asked: {text}"
    if len(tally.questions) > SHOWN:
        yield f"  and {len(tally.questions) - SHOWN} more questions"


def _count(number: int, word: str) -> str:
    return f"{number:,} {word}{'' if number == 1 else 's'}"


def duration(seconds: float) -> str:
    """`4 h 27 min`, `3 min 20 s`, `12.3 s`."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02} s"
    return f"{minutes // 60} h {minutes % 60:02} min"
