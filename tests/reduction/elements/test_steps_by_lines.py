from dataclasses import replace

import numpy as np
import pytest

from labrun.reduction.elements.steps_by_lines import steps_by_lines
from labrun.reduction.plasma.boltzmann import Bend, fit_plot
from labrun.reduction.plasma.response import LOOSE, knots, stiffness
from tests.reduction.plasma.uniform_plasma import lines_at

NONE = np.empty(0)
AT = knots((190.0, 961.0), NONE)
SMOOTH = Bend(AT, np.zeros(len(AT)), stiffness(AT, NONE, LOOSE))


@pytest.fixture
def lines():
    return lines_at(10_000.0, 17.0, elements=("Si", "Fe", "Mg", "Ca", "Ti"))


def steps_of(lines):
    return steps_by_lines(lines, fit_plot(lines, bend=SMOOTH), SMOOTH)


@pytest.mark.parametrize(("begins_nm", "gain"), [(350.0, 8.0), (400.0, 0.1)])
def test_where_lines_of_the_same_elements_jump_a_detector_begins(lines, begins_nm, gain):
    jump = np.log(gain) * (lines.vacuum_nm > begins_nm)
    places, rises = steps_of(replace(lines, log_area=lines.log_area + jump))
    first = int(np.argmin(np.abs(places - begins_nm)))

    assert places[first] == pytest.approx(begins_nm, abs=10)
    assert rises[first] == pytest.approx(np.log(gain), abs=0.6)


def test_no_step_is_seen_in_a_level_or_smooth_response(lines):
    bent = -1.0 * np.clip((300.0 - lines.vacuum_nm) / 100.0, 0.0, 1.0)

    assert not len(steps_of(lines)[0])
    assert not len(steps_of(replace(lines, log_area=lines.log_area + bent))[0])


def test_an_element_without_an_amount_does_not_count(lines):
    without = replace(lines, element=np.where(lines.element == lines.element[0], 3, lines.element))

    assert not len(steps_by_lines(without, fit_plot(lines, bend=SMOOTH), SMOOTH)[0])
