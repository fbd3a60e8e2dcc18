"""How well each point lies within its class (Rousseeuw, J. Comput. Appl. Math. 20, 53 (1987))."""

import numpy as np

from ...spectrum.spectrum import FloatArray, IntArray

MOST_COMPARED = 4_000  # points that each is compared with
TOGETHER = 512  # points whose distances are held in memory at once


def silhouettes(x: FloatArray, label: IntArray) -> FloatArray:
    """s = (b - a) / max(a, b) of each row of x (n, d), -1 to 1; shape (n,).

    a: mean distance to the others of its class; b: to the nearest other class. A point alone in
    its class, and a single class, have 0. Of more than 4,000 points every m-th of the sorted rows
    stands for all.
    """
    from scipy.spatial.distance import cdist

    k = int(label.max(initial=-1)) + 1
    if k < 2:
        return np.zeros(len(x))
    order = np.lexsort((*x.T[::-1], label))
    compared = order[:: -(-len(order) // MOST_COMPARED)]
    member = np.zeros((len(compared), k))
    member[np.arange(len(compared)), label[compared]] = 1.0
    count = member.sum(axis=0)
    found = np.zeros(len(x))
    among = np.isin(np.arange(len(x)), compared)
    for first in range(0, len(x), TOGETHER):
        rows = np.arange(first, min(first + TOGETHER, len(x)))
        total = cdist(x[rows], x[compared]) @ member
        own = label[rows]
        others = count[own] - among[rows]  # without the point itself
        here = np.arange(len(rows))
        a = np.divide(total[here, own], others, out=np.zeros(len(rows)), where=others > 0)
        mean = np.divide(total, count, out=np.full(total.shape, np.inf), where=count > 0)
        mean[here, own] = np.inf
        b = mean.min(axis=1)
        widest = np.maximum(a, b)
        score = np.divide(b - a, widest, out=np.zeros(len(rows)), where=widest > 0)
        found[rows] = np.where((others > 0) & np.isfinite(b), score, 0.0)
    return found
