"""When a run will end: from the pace of its last iterations, as a range that narrows."""

import time
from statistics import quantiles

from .counts import Table


def per_minute(table: Table) -> float | None:
    """Iterations per minute, over the last ones."""
    took = sum(table.paces)
    return round(60 * len(table.paces) / took, 2) if took > 0 else None


def eta(table: Table) -> tuple[float, float] | None:
    """The times (20th and 80th percentile) between which the loop will end.

    Each remaining iteration is assumed to take as long as the slower or faster ones of the last;
    None until three are known, once all have ended, and if the number of iterations is unknown.
    """
    left = 0 if table.total is None else table.total - table.done
    if left <= 0 or len(table.paces) < 3:
        return None
    cuts = quantiles(table.paces, n=10, method="inclusive")
    now = time.time()
    return now + left * cuts[1], now + left * cuts[7]
