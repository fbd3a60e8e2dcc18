import numpy as np
import pytest

from labrun.reduction.spectrum.bad import bridged, mark_bad


@pytest.fixture
def counts(make_truth):
    return make_truth([(500.0, 670.78, 0.06, 0.02), (900.0, 300.0, 0.05, 0.02)]).intensity


def test_a_good_spectrum_has_no_bad_channels(counts):
    assert not mark_bad(counts).any.any()


def test_each_kind_is_told_apart(counts):
    counts[1_000], counts[2_000], counts[3_000] = np.nan, 0.0, counts[3_000] + 900
    bad = mark_bad(counts)

    assert np.flatnonzero(bad.missing).tolist() == [1_000]
    assert np.flatnonzero(bad.dead).tolist() == [2_000]
    assert np.flatnonzero(bad.hot).tolist() == [3_000]


def test_a_plateau_of_full_channels_is_marked_whole(counts):
    full = np.minimum(counts, counts.max() * 0.7)
    bad = mark_bad(full)

    assert bad.full.sum() >= 2
    assert np.all(full[bad.full] == full.max())


def test_bad_channels_are_bridged_and_not_all_can_be():
    bad = np.array([False, True, True, False])

    assert bridged(np.array([1.0, 9.0, 9.0, 4.0]), bad).tolist() == [1, 2, 3, 4]
    with pytest.raises(ValueError, match="every channel"):
        bridged(np.ones(3), np.ones(3, dtype=bool))


def test_a_spectrum_of_nan_and_a_short_one_are_no_error():
    assert mark_bad(np.full(20, np.nan)).any.all()
    assert not mark_bad(np.ones(5)).any.any()
