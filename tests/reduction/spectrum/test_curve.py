import numpy as np
import pytest

from labrun.reduction.spectrum.curve import (
    along,
    bridge,
    even_means,
    joined,
    median,
    middle_within,
    pitch_of,
    quantile,
    softened,
    usual_pitch_nm,
)

RNG = np.random.default_rng(5)
VALUES = RNG.normal(0, 1, 999)


def test_joined_blocks_are_what_numpy_makes_of_them():
    low = RNG.normal(0, 1, 7)
    known = np.interp(np.arange(100), 6.5 + 13 * np.arange(7), low)

    assert joined(low, 6.5, 13.0, 100) == pytest.approx(known, abs=1e-12)
    assert joined(low[:1], 0.0, 3.0, 5).tolist() == [low[0]] * 5


def test_values_along_an_axis_are_what_numpy_makes_of_them():
    x, knots = np.sort(RNG.uniform(0, 10, 200)), np.array([1.0, 2.0, 2.5, 8.0])
    heights = np.array([3.0, -1.0, 4.0, 0.0])

    assert along(x, knots, heights) == pytest.approx(np.interp(x, knots, heights), abs=1e-12)
    assert along(x, knots[:1], heights[:1]).tolist() == [3.0] * 200


@pytest.mark.parametrize("where", [[0, 1], [50, 51, 52, 70], [98, 99], [0, 99]])
def test_a_bridge_is_what_numpy_makes_of_it(where):
    bad = np.zeros(100, bool)
    bad[where] = True
    y, channel = VALUES[:100], np.arange(100)

    assert bridge(y, bad) == pytest.approx(np.interp(channel, channel[~bad], y[~bad]), abs=1e-12)


def test_means_and_softened_are_convolutions_with_repeated_ends():
    padded = np.pad(VALUES, 4, mode="edge")
    means = np.convolve(padded, np.full(9, 1 / 9), "valid")[1::3]
    soft = np.convolve(np.pad(VALUES, 1, mode="edge"), [0.25, 0.5, 0.25], "valid")

    assert even_means(VALUES, 9, 1, 3) == pytest.approx(means, abs=1e-12)
    assert softened(VALUES) == pytest.approx(soft, abs=1e-12)
    assert softened(VALUES[:1]).tolist() == [VALUES[0]] and len(softened(VALUES[:0])) == 0


@pytest.mark.parametrize("q", [0.0, 0.1, 0.35, 0.5, 0.999, 1.0])
@pytest.mark.parametrize("n", [1, 2, 10, 999])
def test_quantiles_are_those_of_numpy(q, n):
    assert quantile(VALUES[:n], q) == pytest.approx(np.quantile(VALUES[:n], q), abs=1e-12)


def test_the_median_of_nothing_is_no_number():
    assert np.isnan(median(np.empty(0)))


def test_the_middle_of_what_lies_within_is_its_median():
    values = np.concatenate([VALUES + 0.4, np.full(50, 40.0), [np.nan]])
    inside = values[np.abs(values) < 3.0]

    assert middle_within(values, 3.0) == pytest.approx(np.median(inside), abs=5e-3)
    assert middle_within(np.array([7.0]), 3.0) == 0.0


def test_pitches_are_those_of_numpy():
    x = np.cumsum(RNG.uniform(0.02, 0.05, 5_000))

    assert pitch_of(x) == pytest.approx(np.gradient(x))
    assert pitch_of(x[:1]).tolist() == [1.0]
    assert usual_pitch_nm(np.linspace(200, 900, 20_001)) == pytest.approx(0.035)
