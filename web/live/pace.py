"""When a run will be over: from the pace of its last iterations, as a range that narrows."""

import time
from statistics import quantiles

from .counts import Table


def per_minute(table: Table) -> float | None:
    """Iterations a minute, over the last ones."""
    took = sum(table.paces)
    return round(60 * len(table.paces) / took, 2) if took > 0 else None


def eta(table: Table) -> tuple[float, float] | None:
    """Between these instants (20th to 80th percentile) the loop will be over.

    Each iteration left is taken to last as long as the slower or quicker ones of the last; None
    until three are known, or where nobody knows how many there are.
    """
    if table.total is None or len(table.paces) < 3:
        return None
    left = max(0, table.total - table.done)
    cuts = quantiles(table.paces, n=10, method="inclusive")
    now = time.time()
    return now + left * cuts[1], now + left * cuts[7]
