"""Fit what a whole spectrum tells of standards: PLS and principal components, by scikit-learn.

Standards are rows, each the mean of its shots, and are left out whole: shots of one standard never
stand on both sides of a cross-validation.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from ..spectrum.spectrum import BoolArray, FloatArray
from .multivariate import ORDINARY, Likeness, Place, Pls, distances, packed

LEAST = 6  # standards
MOST_COMPONENTS = 8
FOLDS = 10
AS_GOOD = 1.1  # of the least squared error: more components that gain less are left out
FAINT = 1e-3  # of the greatest spread of a bin, added to each before bins are weighed
EXPLAINED = 0.99  # of the variance, by the principal components that are kept


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """The model of all standards, and what models without a standard read from its shots, wt %: an
    array for each standard."""

    model: Pls
    left_out: list[FloatArray]


def fit_pls(shots: Sequence[FloatArray], wt_percent: FloatArray) -> Fitted:
    """A PLS model of one element. shots: binned spectra (shots, m) of each of n standards; wt_percent (n,).

    The number of components is what cross-validates best over standards; where a standard is left out
    it is chosen without that one, too.
    """
    x = np.array([own.mean(axis=0) for own in shots])
    left_out: list[FloatArray] = [np.zeros(0)] * len(shots)
    for out in _folds(wt_percent):
        kept = ~out
        models = _models(x[kept], wt_percent[kept], _components(x[kept], wt_percent[kept]))
        for k in np.flatnonzero(out).tolist():
            offset, coefficients = models[-1]
            left_out[k] = offset + shots[k] @ coefficients
    n = _components(x, wt_percent)
    offset, coefficients = _models(x, wt_percent, n)[-1]
    return Fitted(
        Pls(n, float(offset), packed(coefficients), packed(_importance(x, wt_percent, n))), left_out
    )


def _folds(wt_percent: FloatArray) -> Iterator[BoolArray]:
    """Masks of standards to leave out together, each over the whole range of concentrations."""
    rank = np.argsort(np.argsort(wt_percent, kind="stable"), kind="stable")
    n = min(len(wt_percent), FOLDS)
    for k in range(n):
        yield rank % n == k


def _components(x: FloatArray, y: FloatArray) -> int:
    """The fewest components with about the least cross-validated error."""
    most = min(MOST_COMPONENTS, len(y) - 1 - -(-len(y) // FOLDS))
    error = np.zeros(most)
    for out in _folds(y):
        models = _models(x[~out], y[~out], most)
        for a in range(most):
            offset, coefficients = models[min(a, len(models) - 1)]
            error[a] += float(np.sum((offset + x[out] @ coefficients - y[out]) ** 2))
    return int(np.flatnonzero(error <= AS_GOOD * error.min())[0]) + 1


def weights(x: FloatArray) -> FloatArray:
    """Of bins, by the square root of their spread over standards (Pareto), shape (m,)."""
    spread = x.std(axis=0)
    return 1 / np.sqrt(spread + FAINT * max(float(spread.max()), 1e-300))


def _turned(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean, weights of bins, and the axes (k, m) in which n weighted spectra differ: no more than n - 1,
    so that a regression in them is the same and far smaller."""
    mean, weight = x.mean(axis=0), weights(x)
    _, size, axes = np.linalg.svd((x - mean) * weight, full_matrices=False)
    return mean, weight, axes[size > 1e-9 * size[0]]


def _regression(x: FloatArray, y: FloatArray, components: int):
    from sklearn.cross_decomposition import PLSRegression

    mean, weight, axes = _turned(x)
    turned = ((x - mean) * weight) @ axes.T
    fitted = PLSRegression(n_components=max(1, min(components, len(axes))), scale=False)
    return mean, weight, axes, fitted.fit(turned, y)


def _models(x: FloatArray, y: FloatArray, components: int) -> list[tuple[float, FloatArray]]:
    """(offset, coefficients of bins) with 1, 2, ... components."""
    mean, weight, axes, fitted = _regression(x, y, components)
    found = []
    for a in range(1, fitted.x_rotations_.shape[1] + 1):
        own = fitted.x_rotations_[:, :a] @ fitted.y_loadings_[0, :a]
        coefficients = (axes.T @ own) * weight
        found.append((float(y.mean() - mean @ coefficients), coefficients))
    return found


def _importance(x: FloatArray, y: FloatArray, components: int) -> FloatArray:
    """Variable importance in projection of each bin, (m,): squares have a mean of 1."""
    _, _, axes, fitted = _regression(x, y, components)
    weighed = axes.T @ fitted.x_weights_  # axes are orthonormal: lengths stay 1
    told = fitted.y_loadings_[0] ** 2 * (fitted.x_scores_**2).sum(axis=0)
    return np.sqrt(x.shape[1] * (weighed**2 @ told) / max(float(told.sum()), 1e-300))


def fit_likeness(shots: Sequence[FloatArray], samples: Sequence[str]) -> Likeness:
    """Principal components of standards' mean spectra, with limits of T2 and Q."""
    x = np.array([own.mean(axis=0) for own in shots])
    mean, weight = x.mean(axis=0), weights(x)
    axes, variances, explained, scores = _principal((x - mean) * weight, None)
    t2, q = np.zeros(len(x)), np.zeros(len(x))
    seen: list[tuple[FloatArray, FloatArray]] = []
    for k, own in enumerate(shots):
        rest = np.delete(x, k, axis=0)
        other_mean = rest.mean(axis=0)
        other, spread, _, _ = _principal((rest - other_mean) * weight, len(axes))
        seen.append(distances((own - other_mean) * weight, other, spread))
        t2[k], q[k] = (float(np.median(one)) for one in seen[-1])
    t2_limit, q_limit = (_limit(np.concatenate([one[side] for one in seen])) for side in (0, 1))
    places = tuple(
        Place(sample, (float(s[0]), float(s[1] if len(s) > 1 else 0.0)), float(a), float(b))
        for sample, s, a, b in zip(samples, scores, t2, q, strict=True)
    )
    return Likeness(
        packed(mean), packed(weight), tuple(packed(one) for one in axes), tuple(variances.tolist()),
        tuple(explained.tolist()), t2_limit, q_limit, places,
    )  # fmt: skip


def _principal(x: FloatArray, components: int | None):
    """Axes (k, m), variances and explained parts (k,), scores (n, k) of centred spectra; None: as many as
    explain `EXPLAINED` of the variance, at most a third of the standards."""
    from sklearn.decomposition import PCA

    most = min(MOST_COMPONENTS, max(2, len(x) // 3))
    fitted = PCA(n_components=components or most, svd_solver="full").fit(x)
    told = np.asarray(fitted.explained_variance_ratio_)
    n = components or min(int(np.searchsorted(np.cumsum(told), EXPLAINED)) + 1, most)
    variances = np.maximum(np.asarray(fitted.explained_variance_)[:n], 1e-300)
    return np.asarray(fitted.components_)[:n], variances, told[:n], fitted.transform(x)[:, :n]


def _limit(values: FloatArray) -> float:
    """What `ORDINARY` of such values are below, their logarithms taken as normal."""
    logs = np.log(np.maximum(values, 1e-300))
    return float(np.exp(logs.mean() + ndtri(ORDINARY) * logs.std(ddof=1)))
