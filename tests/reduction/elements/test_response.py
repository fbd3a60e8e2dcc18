from dataclasses import replace

import numpy as np
import pytest

from labrun.reduction.elements.response import Missing, find_response
from labrun.reduction.plasma.boltzmann import Bend
from labrun.reduction.plasma.response import LOOSE, knots, stiffness
from tests.reduction.plasma.uniform_plasma import lines_at

NOTHING = Missing(np.empty(0, np.int64), np.empty(0), np.empty(0))
STATE = (10_000.0, 1e17)
SEAM = np.array([350.0])


def sought(lines, missing=NOTHING, seams_nm=SEAM):
    at = knots((190.0, 961.0), seams_nm)
    bend = Bend(at, np.zeros(len(at)), stiffness(at, seams_nm, LOOSE))
    return find_response(lines, missing, (STATE,), bend)


def found(lines, missing=NOTHING, seams_nm=SEAM):
    response = sought(lines, missing, seams_nm)
    assert response is not None
    return response


@pytest.fixture
def lines():
    return lines_at(10_000.0, 17.0, elements=("Si", "Fe", "Mg", "Ca", "Ti"))


def test_a_level_response_is_not_claimed(lines):
    assert sought(lines) is None


def test_the_step_between_two_detectors_is_found(lines):
    step = np.log(3.9) * (lines.vacuum_nm > 350.0)
    response, state = found(replace(lines, log_area=lines.log_area + step))
    below, above = response.at(np.array([345.0, 355.0]))

    assert state == STATE
    assert above - below == pytest.approx(np.log(3.9), abs=0.15)


def test_a_smooth_roll_off_is_followed_without_a_seam(lines):
    bent = -3.0 * np.clip((300.0 - lines.vacuum_nm) / 100.0, 0.0, 1.0)
    response, _ = found(replace(lines, log_area=lines.log_area + bent), seams_nm=np.empty(0))
    low, high = response.at(np.array([240.0, 400.0]))

    assert high - low == pytest.approx(1.8, abs=0.4)


def test_lines_that_are_missing_bound_it_and_its_error_grows_where_nothing_tells(lines):
    seen = lines.vacuum_nm > 260.0
    step = np.log(8.0) * (lines.vacuum_nm > 350.0)
    kept = _only(replace(lines, log_area=lines.log_area + step), seen)
    free = found(kept)[0]
    gone = Missing(lines.element[~seen], lines.vacuum_nm[~seen], (lines.log_area + 3.0)[~seen]
                   - np.median(lines.log_area - lines.thin(*STATE)))  # fmt: skip
    bound = found(kept, gone)[0]
    at_end, within = free.error_at(np.array([200.0, 400.0]))

    assert bound.at(np.array([225.0])) < free.at(np.array([225.0])) - 0.5
    assert at_end > 2 * within


def _only(lines, chosen):
    rows = chosen[lines.entry]
    place = np.cumsum(chosen) - 1
    each = {name: getattr(lines, name)[chosen] for name in
            ("log_area", "error", "element", "vacuum_nm", "width_nm", "e_k_ev", "ion")}  # fmt: skip
    return replace(lines, rows=lines.rows[rows], entry=place[lines.entry[rows]], **each)
