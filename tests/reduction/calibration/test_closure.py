from dataclasses import replace

import numpy as np
import pytest
from truth import with_vice

from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.reduction import Spectrum, read_spectrum, reduce_spectrum
from labrun.reduction.calibration import closure
from labrun.reduction.calibration.closure import SURELY, _drawn, concentrations, one_point
from labrun.reduction.calibration.rocks import of_rocks
from labrun.reduction.lines.formula import WEIGHT, with_oxygen
from labrun.reduction.plasma.boltzmann import CALIBRATION, Bend, fit_plot
from labrun.reduction.plasma.cool_part import PARTS, cool_parts
from labrun.reduction.plasma.growth import log_depth_of_unit
from labrun.reduction.plasma.response import LEVEL, LOOSE, Response, stiffness
from labrun.reduction.spectrum.response import KnownResponse

LEVEL_RESPONSE = Response(np.array([200.0, 900.0]), np.zeros(2), np.ones(2))


@pytest.fixture(scope="module")
def core():
    """The reduction of a shot at the simulated core."""
    maker = ShotMaker(core=1, seed=3)
    return reduce_spectrum(read_spectrum(maker.csv({"n": 1, "x": 1.2, "y": 3.0, "focus": 1.0})))


@pytest.mark.parametrize("closed", ["oxides", "elements"])
def test_what_is_told_makes_100_percent_with_what_it_binds(core, closed):
    told = {
        name: one.wt_percent
        for name, one in concentrations(core, closed).items()
        if one.wt_percent is not None
    }

    assert "Si" in told
    assert sum(w * with_oxygen(name, closed) for name, w in told.items()) == pytest.approx(100)


def test_each_value_has_an_error_and_an_interval_and_what_is_not_seen_a_limit(core):
    said = concentrations(core, "oxides")
    seen = [one for one in said.values() if one.wt_percent is not None]
    unseen = {name: one for name, one in said.items() if one.wt_percent is None}

    assert all(0 < one.low < one.wt_percent < one.high < 100 and one.error > 0 for one in seen)
    assert unseen
    assert not unseen.keys() & set(core.detected)
    assert all(one.flags[0] == "below LOD" and 0 < one.high < 100 for one in unseen.values())


@pytest.mark.parametrize("n", [2, 9])
def test_draws_have_the_mean_and_the_covariance_that_are_asked_for(n):
    half = np.random.default_rng(n).normal(size=(n, n))
    covariance = half @ half.T
    drawn = _drawn(covariance)

    assert drawn.mean(axis=0) == pytest.approx(0, abs=1e-12)
    assert np.cov(drawn.T) == pytest.approx(covariance, abs=0.12 * np.trace(covariance))


def test_one_standard_makes_up_for_what_all_spectra_lack_alike(core):
    def told(points=None):
        said = concentrations(core, "oxides", points)
        return {name: one for name, one in said.items() if one.wt_percent is not None}

    before = {name: one.wt_percent for name, one in told().items()}
    other = next(name for name in before if name != "Si")
    points = one_point([(before | {other: 3 * before[other]}, [core])])
    after, of_one = told(points), told({"Si": points["Si"]})

    ratio = 3 * before[other] / before["Si"]
    assert after[other].wt_percent / after["Si"].wt_percent == pytest.approx(
        ratio, rel=0.25
    )  # a mean of draws
    assert "no standard told it" in of_one[other].flags
    assert "no standard told it" not in after[other].flags
    assert one_point([({"Si": before["Si"]}, [core])]) == {}


def test_the_scatter_of_a_standards_shots_takes_the_place_of_the_fits_errors(core):
    known = {name: one.wt_percent or 0.0 for name, one in concentrations(core, "oxides").items()}
    one_shot, alike = (one_point([(known, [core] * n)]) for n in (1, 3))
    errors = [
        {
            name: one.error
            for name, one in concentrations(core, "oxides", points).items()
            if one.error
        }
        for points in (one_shot, alike)
    ]

    assert all(point.error == pytest.approx(0, abs=1e-9) for point in alike.values())
    assert errors[0].keys() == errors[1].keys() != set()
    assert all(errors[1][name] < errors[0][name] for name in errors[1])


def test_a_second_standard_shows_how_unlike_plasmas_are(core):
    known = {"Si": 20.0, "Ca": 8.0}
    one, two = (one_point([(known, [core] * 3)] * n) for n in (1, 2))

    def errors(points):
        return sum(told.error or 0.0 for told in concentrations(core, "oxides", points).values())

    assert all(point.error == pytest.approx(0, abs=1e-9) for point in one.values())
    assert (one["Ca"].standards, two["Ca"].standards) == (1, 2)
    assert errors(one) > 1.01 * errors(two)  # calcium ionises little more easily than silicon


@pytest.mark.parametrize("response", [None, LEVEL_RESPONSE])
def test_lines_that_scatter_beyond_their_errors_make_amounts_unsure(core, monkeypatch, response):
    plot, lines = core.identified.plot, core.identified.lines
    sign = np.random.default_rng(0).choice([-1, 1], len(lines))

    def error(times):
        off = times * sign * np.hypot(lines.error, CALIBRATION)
        more = replace(lines, log_area=lines.log_area - plot.residual + off)
        found = replace(
            core.identified, lines=more, plot=replace(plot, residual=off), response=response
        )
        told = concentrations(replace(core, identified=found), "oxides")
        return sum(one.error or 0.0 for one in told.values())

    few, many = error(0.5), error(1.6)
    monkeypatch.setattr(closure, "LESS_SURE", 1.0)
    less = error(1.6)
    monkeypatch.setattr(closure, "NOT_EXPLAINED", 0.0)

    assert error(0.5) == few
    assert less < many
    assert error(1.6) < many / 2


def test_the_pictures_of_one_zone_and_of_two_are_both_drawn_where_lines_told_the_response(
    core, monkeypatch
):
    found = replace(core, identified=replace(core.identified, response=LEVEL_RESPONSE))
    monkeypatch.setattr(closure, "SURELY", np.inf)
    both = concentrations(found, "oxides")["Si"]
    monkeypatch.setattr(closure, "BENT_SHARE", 1)
    two = concentrations(found, "oxides")["Si"]
    monkeypatch.setattr(closure, "BENT_SHARE", 1_000)
    one = concentrations(found, "oxides")["Si"]

    assert (
        min(one.wt_percent, two.wt_percent)
        <= both.wt_percent
        <= max(one.wt_percent, two.wt_percent)
    )


def test_what_lines_leave_open_goes_toward_what_rocks_are_made_of():
    names, rock = np.array(["Si", "K", "Li", "Al"]), np.array([True, True, False, True])
    usual = of_rocks(("Si", "K", "Al"))[0]
    errors = np.array([0.05, 1.5, 0.5, 0.05])

    def moved(potassium):
        """How far potassium goes toward rocks, what its error is then, and where the others go."""
        found = np.array([usual[0], usual[1] + potassium, 0.0, usual[2]])
        drawn = closure._as_rocks(found + _drawn(np.diag(errors**2)), names, rock)
        beside = drawn - drawn[:, :1]
        off = beside.mean(axis=0) - (found - found[0])
        return -off[1] / potassium, beside[:, 1].std(), off[[2, 3]]

    near, far = moved(1.5), moved(8.0)

    assert near[2] == pytest.approx(0, abs=0.05)  # not of the eight elements, and well known
    assert 0.3 < far[0] < near[0] < 0.7  # far from all rocks, it is likely none
    assert near[1] < errors[1] > far[1]
    drawn = _drawn(np.eye(4))
    assert closure._as_rocks(drawn, names, ~rock) is drawn


def test_how_well_a_response_is_known_counts_and_noise_is_of_the_counts_before_it(core):
    maker = ShotMaker(core=1, seed=3)
    seen = read_spectrum(maker.csv({"n": 1, "x": 1.2, "y": 3.0, "focus": 1.0}))
    nm = np.array([200.0, 400.0, 900.0])

    def reduced(error):
        known = KnownResponse(nm, np.array([0.05, 1.0, 0.3]), np.full(3, error))
        uneven = replace(seen, intensity=seen.intensity * known.at(seen.wavelength_nm))
        return known, reduce_spectrum(known.divided_out(uneven))

    known, well = reduced(0.01)
    badly = replace(well, response=reduced(0.8)[0])
    uneven = reduce_spectrum(replace(seen, intensity=seen.intensity * known.at(seen.wavelength_nm)))
    said = [concentrations(one, "oxides").values() for one in (well, badly)]
    errors = [sum(one.error or 0.0 for one in each) for each in said]

    assert len(well.peaks) == len(uneven.peaks)
    assert well.peaks.area * known.at(well.peaks.centre_nm) == pytest.approx(uneven.peaks.area)
    assert well.peaks.area_error / well.peaks.area == pytest.approx(
        uneven.peaks.area_error / uneven.peaks.area
    )
    assert errors[0] < errors[1]


def test_an_amount_that_is_not_counted_may_be_any_number():
    told = closure._told_well(
        np.array([0.0, 1.0, 800.0]), 0.01 * np.eye(3), np.array([True, True, False])
    )

    assert told.tolist() == [True, True, False]


LEVEL_BEND = Bend(np.empty(0), np.empty(0), np.empty((0, 0)))


def through_a_cool_zone(core, part):
    """The core's lines as a plasma with a part of its atoms cool has them, integrated along the profile."""
    plot, lines = core.identified.plot, core.identified.lines
    scale = plot.log_scale[lines.element]
    at, light = np.linspace(-300, 300, 20_001), 0.0
    for share, cooler, fewer in ((1 - part, 1.0, 1.0), (part, 0.5, 0.3)):
        kelvin = cooler * plot.temperature_k
        thin = share * np.exp(lines.thin(kelvin, fewer * 10**plot.log10_ne) + scale)
        width = fewer * lines.width_nm * 10**plot.log10_ne / 1e17
        unit = np.exp(plot.log_opacity + log_depth_of_unit(lines.vacuum_nm, width, kelvin))
        passed = np.exp(-(thin * unit)[:, None] / (1 + (at / fewer) ** 2))
        light = light * passed + (1 - passed) / (np.pi * fewer * unit)[:, None]
    return replace(lines, log_area=np.log(light.sum(axis=1) * 0.03))


def test_lines_tell_how_much_of_the_plasma_is_cool_and_the_amounts_beside_it(core):
    plot, middle = core.identified.plot, []
    known = plot.log_scale[plot.names]
    for part in (0.004, 0.25):
        lines = through_a_cool_zone(core, part)
        found = cool_parts(lines, fit_plot(lines), LEVEL_BEND)
        odds = np.array([one.odds for one in found])
        amounts = odds @ np.array([one.log_scale for one in found])
        middle.append(odds @ np.log(PARTS))

        assert odds.sum() == pytest.approx(1)
        assert amounts - amounts.mean() == pytest.approx(known - known.mean(), abs=0.3)
    assert middle[1] - middle[0] > 1


def test_lines_tell_a_cool_part_from_a_response_that_is_off(core):
    at, odds = np.arange(200.0, 941.0, 40.0), []
    for off in (0.0, 0.8):
        lines = through_a_cool_zone(core, 0.25)
        bent = off * np.sin(lines.vacuum_nm / 40)
        lines = replace(lines, log_area=lines.log_area + bent)
        plot = fit_plot(lines)
        level, loose = (
            max(
                part.evidence
                for part in cool_parts(lines, plot, Bend(at, 0 * at, stiff), PARTS[2:5])
            )
            for stiff in (stiffness(at, np.empty(0), usual) for usual in (LEVEL, LOOSE))
        )
        odds.append(level - loose)

    assert odds[0] > SURELY > 0 > odds[1]


def test_no_amounts_are_told_without_lines():
    noise = np.random.default_rng(1).normal(100, 5, 2_000)

    assert (
        concentrations(reduce_spectrum(Spectrum(np.linspace(200, 900, 2_000), noise)), "oxides")
        == {}
    )


def test_iron_is_counted_as_feo_and_an_alloy_without_oxygen():
    assert 1 / with_oxygen("Fe", "oxides") == pytest.approx(55.845 / 71.844, rel=1e-4)
    assert 1 / with_oxygen("Al", "oxides") == pytest.approx(0.52925, rel=1e-4)
    assert with_oxygen("Fe", "elements") == 1.0


@pytest.mark.slow
def test_amounts_of_a_made_spodumene_are_within_three_errors():
    truth = with_vice("none", 0)
    said = concentrations(reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity)), "oxides")
    mass = {e: n * WEIGHT[e] for e, n in truth.shares.items() if e in ("Li", "Al", "Si", "Fe")}
    whole = sum(m * with_oxygen(e, "oxides") for e, m in mass.items())

    for element in ("Li", "Al", "Si"):
        one = said[element]
        assert abs(one.wt_percent - 100 * mass[element] / whole) < 3 * one.error + 0.2
