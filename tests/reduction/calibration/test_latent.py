"""PLS and principal components of made spectra: two elements whose lines overlap, 15 standards."""

import numpy as np
import pytest

from labrun.reduction.calibration.calibrate import model_curve
from labrun.reduction.calibration.latent import fit_likeness, fit_pls
from labrun.reduction.calibration.multivariate import unpacked

X = np.arange(60.0)
LINES = np.array([np.exp(-0.5 * ((X - at) / 2) ** 2) for at in (20, 24)])


def shots(rng, both, n=3, noise=0.02):
    """Binned spectra (n, 60) of a sample with so much of two elements, and a third line at 45."""
    other = np.exp(-0.5 * ((X - 45) / 2) ** 2) * rng.uniform(0.5, 1.5)
    return np.asarray(both) @ LINES + other + noise * rng.standard_normal((n, len(X)))


@pytest.fixture(scope="module")
def standards():
    rng = np.random.default_rng(5)
    known = rng.uniform(0, 3, (15, 2))
    return known, [shots(rng, one) for one in known]


def test_two_elements_whose_lines_overlap_are_told_apart(standards):
    known, spectra = standards
    fitted = fit_pls(spectra, known[:, 0])
    left_out = np.array([one.mean() for one in fitted.left_out])
    rng = np.random.default_rng(6)
    unknown = [fitted.model.read(shots(rng, (1.2, b)).mean(axis=0)) for b in (0.2, 1.5, 2.8)]

    assert 2 <= fitted.model.components <= 5
    assert np.sqrt(np.mean((left_out - known[:, 0]) ** 2)) < 0.1
    assert unknown == pytest.approx([1.2] * 3, abs=0.15)


def test_a_standard_is_left_out_with_all_its_shots(standards):
    """What the others say of it is the same whatever is written of it, as long as its rank is."""
    known, spectra = standards
    c = known[:, 0]
    last = int(np.argmax(c))
    other = c.copy()
    other[last] = 40.0

    first, second = fit_pls(spectra, c), fit_pls(spectra, other)

    assert second.left_out[last] == pytest.approx(first.left_out[last])
    assert second.model.coefficients != first.model.coefficients


def test_a_model_is_read_as_it_is_with_the_error_of_standards_that_were_left_out(standards):
    known, spectra = standards
    c = known[:, 0]
    fitted = fit_pls(spectra, c)
    curve, points = model_curve([str(k) for k in range(len(c))], c, fitted)
    off = [one.mean() - true for one, true in zip(fitted.left_out, c, strict=True)]
    told = curve.read(1.2, shots=3)

    assert told.wt_percent == pytest.approx(1.2, abs=1e-3)
    assert told.error == pytest.approx(np.sqrt(np.mean(np.square(off))), rel=0.06)  # Student's t
    assert curve.freedom == len(c) - fitted.model.components - 1
    assert [p.cross_validated - p.wt_percent for p in points] == pytest.approx(off)


def test_importance_is_where_the_element_is(standards):
    known, spectra = standards
    importance = unpacked(fit_pls(spectra, known[:, 0]).model.importance)

    assert np.mean(importance**2) == pytest.approx(1, rel=1e-3)
    assert importance[18:23].min() > 1 > importance[:12].max()


@pytest.mark.parametrize(
    ("what", "which"), [("like them", None), ("another line", 1), ("far out", 0)]
)
def test_q_tells_what_no_standard_has_and_t2_what_is_beyond_them(standards, what, which):
    _, spectra = standards
    found = fit_likeness(spectra, [f"s{k}" for k in range(len(spectra))])
    one = shots(np.random.default_rng(7), (40.0, 1.5) if what == "far out" else (1.0, 1.5))[0]
    one = one + (2 * np.exp(-0.5 * ((X - 5) / 2) ** 2) if what == "another line" else 0)
    far, said = found.far(one), found.outside(one)

    assert all(place.t2 < 2 * found.t2_limit for place in found.places)
    if which is None:
        assert max(far) <= 1
        assert said is None
    else:
        assert far[which] > 5
        assert f"{('T2', 'Q')[which]} is {far[which]:.1f} times its 99 % limit" in said
