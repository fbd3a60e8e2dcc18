"""k-means with the number of classes chosen by silhouette; the same labels for any order of rows.

The iterations are scipy's. What is ours: rows are sorted first, and the starts are drawn here with
a fixed seed (k-means++: Arthur and Vassilvitskii, SODA 2007), so that the result is a function of
the set of points with every version of scipy; of several starts the one with the smallest sum of
squares counts.
"""

import numpy as np

from ...spectrum.spectrum import FloatArray, IntArray
from .silhouette import silhouettes

FEWEST, MOST = 2, 8
STARTS = 20
ITERATIONS = 100
SEED = 1967  # MacQueen's year
ENOUGH = 1_500  # points that choose the number of classes


def sorted_rows(x: FloatArray) -> IntArray:
    """An order of the rows of x (n, d) that is the same for any permutation of them."""
    return np.lexsort(x.T[::-1])


def split(x: FloatArray, k: int) -> IntArray:
    """Labels 0..k-1 of the rows of x, shape (n,), numbered by the mean of the first feature, the
    highest first (then the second, and so on).

    Raises ValueError where there are fewer than k different rows.
    """
    from scipy.cluster.vq import ClusterError, kmeans2

    different = len(np.unique(x, axis=0))
    if different < k:
        raise ValueError(f"{different} different points cannot be split into {k} classes")
    order = sorted_rows(x)
    rows = x[order]
    random = np.random.default_rng(SEED)
    best, least = None, np.inf
    for _ in range(STARTS):
        try:
            centre, label = kmeans2(
                rows, starts(rows, k, random), iter=ITERATIONS, minit="matrix", missing="raise"
            )
        except ClusterError:  # a class lost its last point: try another start
            continue
        squares = float(np.sum((rows - centre[label]) ** 2))
        if squares < least and len(np.unique(label)) == k:
            best, least = label, squares
    if best is None:
        raise ValueError(f"the points do not split into {k} classes")
    labels = np.empty(len(x), dtype=np.int64)
    labels[order] = best
    return numbered(x, labels)


def starts(x: FloatArray, k: int, random: np.random.Generator) -> FloatArray:
    """k different rows of x, far from each other: each drawn by its squared distance to the others.

    Raises ValueError where there are fewer than k different rows.
    """
    chosen = [int(random.integers(len(x)))]
    away = np.sum((x - x[chosen[0]]) ** 2, axis=1)
    while len(chosen) < k:
        total = np.cumsum(away)
        if not total[-1] > 0:
            raise ValueError(f"there are only {len(chosen)} different points")
        chosen.append(int(np.searchsorted(total, random.random() * total[-1], side="right")))
        away = np.minimum(away, np.sum((x - x[chosen[-1]]) ** 2, axis=1))
    return x[chosen]


def numbered(x: FloatArray, labels: IntArray) -> IntArray:
    """The same classes, numbered by their centres: the highest first feature is 0."""
    k = int(labels.max()) + 1
    centre = np.array([x[labels == c].mean(axis=0) for c in range(k)])
    rank = np.empty(k, dtype=np.int64)
    rank[np.lexsort(-np.round(centre, 9).T[::-1])] = np.arange(k)
    return rank[labels]


def choose(x: FloatArray, fewest: int = FEWEST, most: int = MOST) -> tuple[int, dict[int, float]]:
    """The number of classes with the largest mean silhouette, and that of every number tried.

    Of more than 1,500 points only that many, evenly spread over the sorted rows, are used. One class
    if there are fewer than three points or all are alike.
    """
    rows = x[sorted_rows(x)]
    if len(rows) > ENOUGH:
        rows = rows[np.linspace(0, len(rows) - 1, ENOUGH).round().astype(np.int64)]
    different = len(np.unique(rows, axis=0))
    scores = {}
    for k in range(fewest, min(most, different, len(rows) - 1) + 1):
        try:
            scores[k] = float(np.mean(silhouettes(rows, split(rows, k))))
        except ValueError:
            continue
    if not scores:
        return 1, {}
    # Of equal ones the smaller number; rounding keeps the last bit from choosing.
    return max(scores, key=lambda k: (round(scores[k], 9), -k)), scores
