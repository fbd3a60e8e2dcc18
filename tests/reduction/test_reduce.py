import subprocess
import sys

import numpy as np
import pytest
from truth import make_spectrum

from labrun.reduction import Spectrum, reduce_spectrum
from labrun.reduction.lines.air import to_vacuum

CORE = [
    (800.0, 670.781, 0.06, 0.03),
    (300.0, 766.490, 0.06, 0.02),
    (450.0, 288.158, 0.05, 0.01),
    (60.0, 500.0, 0.06, 0.02),
]


def test_the_elements_of_a_spectrum_have_the_areas_that_were_put_in(make_truth):
    truth = make_truth(CORE)
    reduction = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity), ["Li", "K", "Si"])

    assert list(reduction.areas) == ["Li", "K", "Si"]
    assert reduction.areas == pytest.approx({"Li": 800, "K": 300, "Si": 450}, rel=0.05)
    assert 4 <= reduction.n_peaks <= 6


def test_a_vacuum_instrument_sees_the_same_elements(make_truth):
    in_vacuum = [(a, float(to_vacuum(np.array(c))), s, g) for a, c, s, g in CORE]
    truth = make_truth(in_vacuum)
    spectrum = Spectrum(truth.wavelength_nm, truth.intensity)

    assert reduce_spectrum(spectrum, ["Li"], medium="vacuum").areas["Li"] > 700
    assert reduce_spectrum(spectrum, ["Li"], medium="air").areas["Li"] == 0


def test_an_element_that_is_not_there_has_area_zero_and_says_so(make_truth):
    truth = make_truth(CORE)
    spectrum = Spectrum(truth.wavelength_nm[:19_000], truth.intensity[:19_000])
    reduction = reduce_spectrum(spectrum, ["Na", "Cs"])

    assert reduction.areas == {"Na": 0.0, "Cs": 0.0}
    assert reduction.elements["Na"].fate == "no peak"
    assert reduction.elements["Cs"].fate == "outside the spectrum"


def test_a_weak_peak_counts_where_it_was_asked_for_and_nowhere_else(make_truth):
    faint = make_truth([(2.0, 670.781, 0.06, 0.02), (2.0, 500.0, 0.06, 0.02)])
    spectrum = Spectrum(faint.wavelength_nm, faint.intensity)
    asked, not_asked = reduce_spectrum(spectrum, ["Li"]), reduce_spectrum(spectrum, ["Rb"])

    assert asked.elements["Li"].fate == "found"
    assert asked.n_peaks == not_asked.n_peaks + 1


def test_the_figures_are_plain_and_fit_the_contract(make_truth):
    truth = make_truth(CORE)
    figures = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity)).to_dict()

    assert set(figures) == {"areas", "offsets", "temperature", "n_peaks"}
    assert all(type(area) is float for area in figures["areas"].values())
    assert type(figures["n_peaks"]) is int and figures["temperature"] is None


def test_a_bad_channel_on_a_line_costs_little(make_truth):
    truth = make_truth(CORE)
    truth.intensity[np.searchsorted(truth.wavelength_nm, 670.9)] = np.nan
    reduction = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity), ["Li"])

    assert reduction.areas["Li"] == pytest.approx(800, rel=0.1)


@pytest.mark.parametrize("n", [1, 2, 5, 20, 1_000])
def test_a_flat_spectrum_of_any_length_has_no_peaks(n):
    reduction = reduce_spectrum(Spectrum(np.arange(n) * 0.03 + 200.0, np.full(n, 100.0)))

    assert reduction.n_peaks == 0


def test_the_same_spectrum_reduces_to_the_same_bits(make_truth):
    truth = make_truth(CORE)
    spectrum = Spectrum(truth.wavelength_nm, truth.intensity)
    one, two = reduce_spectrum(spectrum), reduce_spectrum(spectrum)

    assert one.peaks.area.tobytes() == two.peaks.area.tobytes()


def test_an_element_without_lines_is_refused_by_name():
    with pytest.raises(ValueError, match="'Os'"):
        reduce_spectrum(Spectrum(np.array([200.0]), np.array([1.0])), ["Os"])


def test_importing_the_package_imports_nothing_heavy():
    heavy = "{'numba', 'scipy', 'matplotlib', 'numpy'}"
    program = f"import sys, labrun.reduction; print(sorted({heavy} & set(sys.modules)))"
    answer = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )

    assert answer.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "counts",
    [
        lambda rng, n: rng.normal(-50, 3, n),
        lambda rng, n: np.zeros(n),
        lambda rng, n: np.linspace(0, 1e5, n),
        lambda rng, n: np.where(np.arange(n) > n // 2, np.nan, rng.normal(1, 0.1, n)),
        lambda rng, n: 1e30 * rng.normal(1, 0.1, n),
        lambda rng, n: 1e-30 * rng.normal(1, 0.1, n),
        lambda rng, n: np.where(rng.random(n) < 0.3, np.nan, rng.normal(9, 1, n)),
    ],
    ids=["negative", "zeros", "ramp", "half without numbers", "huge", "tiny", "a third missing"],
)
def test_odd_counts_claim_no_element(counts):
    n = 10_000
    spectrum = Spectrum(np.linspace(200, 900, n), counts(np.random.default_rng(1), n))
    reduction = reduce_spectrum(spectrum)

    assert reduction.detected == [] and reduction.n_peaks <= 3


def test_a_saturated_line_has_its_channels_marked():
    x = np.linspace(200, 900, 20_000)
    rng = np.random.default_rng(1)
    counts = rng.normal(100, 3, len(x)) + 1e6 * np.exp(-0.5 * ((x - 589) / 0.1) ** 2)
    reduction = reduce_spectrum(Spectrum(x, np.minimum(counts, 65_535)))

    assert reduction.bad.full.sum() > 2


@pytest.mark.parametrize("n", [100, 1_000_000])
def test_few_and_very_many_channels_are_spectra_too(n):
    x = np.linspace(580, 600, n)
    rng = np.random.default_rng(2)
    counts = rng.normal(100, 3, n)
    counts += sum(600 * np.exp(-0.5 * ((x - nm) / 0.15) ** 2) for nm in (588.995, 589.592))
    reduction = reduce_spectrum(Spectrum(x, counts), ["Na"])

    assert reduction.areas["Na"] == pytest.approx(600 * 0.15 * 2.507, rel=0.3)


@pytest.mark.parametrize(
    ("vice", "said"),
    [("cut at zero", "the counts were cut off there"), ("bent axis", "from where they should be")],
)
def test_what_was_noticed_of_the_instrument_is_told(vice, said):
    from truth import with_vice

    truth, good = with_vice(vice, 0), with_vice("none", 0)
    found, usual = (
        reduce_spectrum(Spectrum(each.wavelength_nm, each.intensity)) for each in (truth, good)
    )

    assert any(said in note for note in found.notes)
    assert usual.notes == ()


@pytest.mark.slow
def test_counts_that_lie_below_0_have_the_noise_of_others():
    steel = make_spectrum("train", 8)
    above = reduce_spectrum(Spectrum(steel.wavelength_nm, steel.intensity))
    below = reduce_spectrum(Spectrum(steel.wavelength_nm, steel.intensity - 5_000.0))

    assert below.n_peaks == pytest.approx(above.n_peaks, rel=0.02)
    assert below.detected == above.detected
