from dataclasses import replace

import numpy as np
import pytest

from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.reduction import read_spectrum, reduce_spectrum
from labrun.reduction.elements.merged import DOUBTFUL, without_merged


@pytest.fixture(scope="module")
def shot():
    maker = ShotMaker(core=1, seed=3)
    return reduce_spectrum(read_spectrum(maker.csv({"n": 1, "x": 1.2, "y": 3.0, "focus": 1.0})))


def taken_off(shot, found):
    """ln of the light that is taken off each line; what that adds to its error."""
    after = without_merged(found, shot.profiles)
    gains = [one.plot.response.at(one.lines.vacuum_nm) for one in (found, after)]
    off = (found.lines.log_area + gains[0]) - (after.lines.log_area + gains[1])
    return off, np.sqrt(after.lines.error**2 - found.lines.error**2)


def test_light_of_lines_without_a_peak_is_taken_off_those_beside_them(shot):
    found = shot.identified
    off, doubt = taken_off(shot, found)
    most = np.bincount(found.lines.element).argmax()
    scale = found.plot.log_scale.copy()
    scale[most] += 4.0
    more, _ = taken_off(shot, replace(found, plot=replace(found.plot, log_scale=scale)))
    others = found.lines.element != most

    assert off.min() > -1e-9 and off.max() > 0.01
    assert doubt == pytest.approx(DOUBTFUL * off, abs=1e-6)
    assert more[others].sum() > off[others].sum()


def test_nothing_is_done_without_a_plot(shot):
    found = replace(shot.identified, plot=None)

    assert without_merged(found, shot.profiles) is found
