from types import ModuleType

import labrun.reduction as reduction
from labrun.reduction.elements import identify  # noqa: F401  # modules: nothing hides behind them


def test_every_step_is_there_by_name_and_is_no_module():
    things = {name: getattr(reduction, name) for name in reduction.__all__}

    assert not [name for name, thing in things.items() if isinstance(thing, ModuleType)]
    assert not [name for name, thing in things.items() if not thing.__doc__]


def test_the_steps_in_a_row_are_the_whole(reduced):
    truth, whole = reduced("train", 0)
    spectrum = reduction.Spectrum(truth.wavelength_nm, truth.intensity)
    bad = reduction.mark_bad(spectrum.intensity)
    profiles = reduction.fit_profiles(spectrum, bad.any)
    named = reduction.identify_peaks(profiles.wavelength_nm, bad.any, profiles)
    said = reduction.weigh_evidence(named, profiles.peaks)
    plasma = reduction.plasma_state(profiles.peaks, named)

    assert {e for e, found in said.items() if found.status == "detected"} == set(whole.detected)
    assert (
        plasma.temperature_k == whole.temperature_k
        or abs(plasma.temperature_k / whole.temperature_k - 1) < 0.01
    )
