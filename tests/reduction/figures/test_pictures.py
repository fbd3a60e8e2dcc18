import numpy as np
import pytest

from labrun.reduction import Spectrum, element_map, reduce_spectrum
from labrun.reduction.figures.boltzmann import boltzmann_figure
from labrun.reduction.figures.class_map import class_map_figure
from labrun.reduction.figures.class_scatter import class_scatter_figure
from labrun.reduction.figures.concentrations import ContentMaps, concentrations_figure
from labrun.reduction.figures.element_maps import element_maps_figure
from labrun.reduction.figures.fit_window import fit_figure, window_around
from labrun.reduction.figures.line_scan import line_scan_figure
from labrun.reduction.figures.lithium_ratio import lithium_ratio_figure
from labrun.reduction.figures.lithium_share import lithium_share_figure
from labrun.reduction.figures.paper import FORMATS, TWO_COLUMNS_IN, paper, save
from labrun.reduction.figures.series import Series
from labrun.reduction.figures.spectrum import spectrum_figure
from labrun.reduction.figures.temperature_map import temperature_map_figure
from labrun.reduction.maps.classes.classify import classify
from labrun.reduction.maps.points.points import Points
from labrun.reduction.plasma.lithium_share import lithium_share, share_curve
from labrun.reduction.tables.plot import lines_of_plot


def one(value, error=1.0):
    return Series(np.array([value]), np.array([error]))


@pytest.fixture(scope="module")
def pegmatite(reduced):
    """A spectrum with lithium in it, and its reduction."""
    for number in range(20):
        truth, reduction = reduced("train", number)
        if "Li" in reduction.detected and lines_of_plot(reduction) is not None:
            return Spectrum(truth.wavelength_nm, truth.intensity), reduction
    raise AssertionError("no spectrum with lithium among the first twenty")


def texts(figure):
    from matplotlib.text import Text

    return [t.get_text() for t in figure.findobj(Text) if t.get_text()]


@pytest.fixture
def overlaps(monkeypatch):
    """Pairs of texts that a figure draws over each other (a tick beyond the limits is not drawn)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    drawn, draw = [], Text.draw

    def noted(text, renderer):
        if text.get_visible() and text.get_text().strip():
            box = text.get_window_extent(renderer).shrunk(0.9, 0.9)
            drawn.append((text.get_text(), box))
        draw(text, renderer)

    def of(figure):
        drawn.clear()
        FigureCanvasAgg(figure).draw()

        assert len(drawn) > 5
        return [(a, b) for k, (a, p) in enumerate(drawn) for b, q in drawn[:k] if p.overlaps(q)]

    monkeypatch.setattr(Text, "draw", noted)
    return of


@pytest.mark.slow
def test_a_spectrum_names_its_lines_and_no_name_covers_another(pegmatite, overlaps):
    with paper():
        figure = spectrum_figure(pegmatite[1])
        said = texts(figure)

        assert any(name.startswith("Li I 670") for name in said)
        assert overlaps(figure) == []
        assert figure.get_size_inches()[0] == TWO_COLUMNS_IN


def test_a_fit_shows_counts_fit_and_residual(pegmatite, overlaps):
    _, reduction = pegmatite
    with paper():
        figure = fit_figure(reduction, window_around(reduction, 670.8))
        upper, lower = figure.axes

        assert [line.get_label() for line in upper.get_lines()][:3] == [
            "counts", "fit", "background"
        ]  # fmt: skip
        assert lower.get_xlabel().startswith("wavelength in ")
        assert overlaps(figure) == []


def test_a_window_beside_the_spectrum_is_refused(pegmatite):
    with pytest.raises(ValueError, match="fewer than 3 channels from 10 to 20 nm"):
        fit_figure(pegmatite[1], (10.0, 20.0))


def test_lines_of_the_boltzmann_plot_lie_on_the_slope_of_its_temperature(pegmatite, overlaps):
    _, reduction = pegmatite
    with paper():
        figure = boltzmann_figure(reduction)
        axes = figure.axes[0]
        line = axes.get_lines()[0]
        slope = np.diff(line.get_ydata()) / np.diff(line.get_xdata())

        assert slope[0] == pytest.approx(-1 / (8.617333e-5 * reduction.temperature_k), rel=1e-6)
        assert any("K" in text and "±" in text for text in texts(figure))
        assert overlaps(figure) == []


def test_noise_has_no_boltzmann_plot_and_still_a_spectrum():
    x = np.linspace(300, 700, 4_000)
    spectrum = Spectrum(x, 100 + np.random.default_rng(1).normal(0, 5, len(x)))
    reduction = reduce_spectrum(spectrum)
    with pytest.raises(ValueError, match="do not determine a temperature"):
        boltzmann_figure(reduction)
    with paper():
        assert len(spectrum_figure(reduction).axes) == 2


def test_the_share_of_lithium_rises_with_the_temperature_it_is_read_at(pegmatite, overlaps):
    _, reduction = pegmatite
    plotted = lines_of_plot(reduction), reduction.identified.plot, reduction.identified.bend
    found, curve = lithium_share(*plotted), share_curve(*plotted)

    assert 0 < found.share < 1 and found.share_error > 0
    assert np.all(np.diff(curve.share) > 0)
    assert np.all(curve.low <= curve.high)
    assert "Li" in found.elements and "O" not in found.elements
    with paper():
        figure = lithium_share_figure(
            one(reduction.temperature_k), one(found.share, found.share_error), None, curve
        )

        assert figure.axes[0].get_ylabel() == "Li fraction of the cations (atoms)"
        assert overlaps(figure) == []


def test_the_temperature_curve_has_the_measured_points_on_it(overlaps):
    with paper():
        figure = lithium_ratio_figure(one(12_000.0, 300.0), one(0.6, 0.01))
        axes = figure.axes[0]

        assert axes.get_ylim()[1] > 0.6
        assert "measured" in [text.get_text() for text in figure.legends[0].get_texts()]
        assert overlaps(figure) == []


def test_a_line_scan_has_a_strip_an_element_and_the_classes():
    way = np.arange(8.0)
    values = {"Li": way, "K": np.where(way == 3, np.nan, 8 - way)}
    with paper():
        figure = line_scan_figure(way, values, labels=way // 4)

        assert len(figure.axes) == 3
        assert figure.axes[-1].get_xlabel() == "distance along the line (mm)"


def test_a_map_of_temperatures_needs_one():
    hot = element_map([0, 1, 0, 1], [0, 0, 1, 1], [9e3, 1e4, np.nan, 11e3])
    none = element_map([0, 1], [0, 1], [np.nan, np.nan])
    with paper():
        assert "plasma temperature (K)" in texts(temperature_map_figure({"": hot}))
        with pytest.raises(ValueError, match="no temperature"):
            temperature_map_figure({"": none})


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_figure_gives_the_same_bytes(tmp_path, suffix):
    def draw(name):
        with paper():
            figure = lithium_ratio_figure(one(12_000.0, 300.0), one(0.6, 0.01))
            return save(figure, tmp_path / f"{name}.{suffix}").read_bytes()

    assert draw("one") == draw("two")


def test_a_users_own_settings_do_not_change_a_figure(tmp_path):
    import matplotlib

    def draw(name):
        with paper():
            figure = lithium_ratio_figure(one(12_000.0, 300.0), one(0.6, 0.01))
            return save(figure, tmp_path / f"{name}.png").read_bytes()

    before = draw("before")
    with matplotlib.rc_context({"lines.linewidth": 9, "font.size": 30}):
        assert draw("after") == before


def test_every_label_of_a_temperature_map_lies_within_its_figure():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(24) * 0.2, np.arange(12) * 0.2))
    kelvin = np.linspace(11_000, 12_402, len(x))
    with paper():
        figure = temperature_map_figure({"": element_map(x, y, kelvin)})
        figure.draw_without_rendering()
        bar = figure.axes[-1]
        low, high = bar.get_xlim()
        shown = [
            tick.label1 for tick in bar.xaxis.get_major_ticks() if low <= tick.get_loc() <= high
        ]

        assert shown[-1].get_text() == "12,400"
        assert all(label.get_window_extent().x1 <= figure.bbox.x1 for label in shown)


def test_ranges_below_the_maps_have_their_unit():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(4.0), np.arange(3.0)))
    maps = {"Li 670.8 nm": element_map(x, y, x)}
    with paper():
        said = texts(
            element_maps_figure(maps, below={"Li 670.8 nm": "0 to 2,359"}, below_in="counts nm")
        )

        assert "the range below each map (counts nm)" in said


@pytest.mark.parametrize("own_bars", [None, "area (counts nm)"])
@pytest.mark.parametrize(("nx", "ny", "n"), [(24, 12, 12), (21, 51, 3), (3, 40, 8), (40, 3, 2)])
def test_no_text_of_element_maps_covers_another(own_bars, nx, ny, n, overlaps):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(nx) * 0.2, np.arange(ny) * 0.2))
    area = 1e4 * np.where(x > 0.3, x + y, np.nan)
    maps = {rf"$\bf{{Li}}$ {600 + k}.8 nm": element_map(x, y, area) for k in range(n)}
    with paper():
        figure = element_maps_figure(maps, "2026-11-21_map", own_bars=own_bars)

        assert overlaps(figure) == []


@pytest.mark.parametrize(("nx", "ny", "n"), [(14, 8, 7), (21, 51, 3), (3, 40, 2), (40, 3, 1)])
def test_what_is_below_a_limit_above_the_standards_or_not_measured_looks_different(
    nx, ny, n, overlaps
):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(nx) * 0.2, np.arange(ny) * 0.2))
    where = np.arange(len(x)) % 4

    def drawn(values):
        return element_map(x, y, values)

    one = ContentMaps(
        drawn(np.where(where == 0, 1.234 + x, np.nan)), drawn(np.where(where == 0, 0.01 + y, np.nan)),
        drawn(np.where(where == 1, 1.0, np.nan)), drawn(np.where(where == 2, 1.0, np.nan)),
    )  # fmt: skip
    with paper():
        figure = concentrations_figure({f"E{k}": one for k in range(n)}, "2026-11-21_map")
        said = texts(figure)

        assert overlaps(figure) == []
        assert {"below LOD", "above the standards", "not measured"} <= set(said)
        assert len(colours_of_cells(figure, nx * ny)) == 4


def colours_of_cells(figure, cells):
    """How the first map shows the first four cells of its lowest row."""
    panel = figure.axes[0]
    shown = {}
    for mesh in [m for m in panel.collections if m.get_array() is not None]:
        values = np.ma.ravel(mesh.get_array())

        assert len(values) == cells
        for at in (k for k in range(4) if not np.ma.getmaskarray(values)[k]):
            shown[at] = mesh.to_rgba(values)[at]
    hole = [(*panel.get_facecolor(),)] * (4 - len(shown))
    return {tuple(colour) for colour in shown.values()} | set(hole)


def test_classes_are_named_beside_their_map_and_above_their_plane(overlaps):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(8.0), np.arange(6.0)))
    li, h = 100.0 * (x > 3) + y, 50.0 * (y > 2) + x
    nothing = np.full(48, np.nan)
    points = Points(
        [str(k) for k in range(48)], [""] * 48, x, y, "mm", {"Li": li, "H": h},
        {"Li": nothing, "H": nothing}, {"Li": 670.8}, nothing, nothing, nothing, nothing,
        np.full(48, -1), None,
    )  # fmt: skip
    classes = classify(points)
    with paper():
        plane = class_scatter_figure(points, classes)
        label = np.where(x == 7, -1.0, classes.label)
        both = class_map_figure({s: element_map(x, y, label) for s in ("A", "B")}, classes)

        assert plane.axes[0].get_xlabel() == "Li 670.8 nm, area (counts nm)"
        assert overlaps(plane) == [] and overlaps(both) == []
        assert "none: no signal" in texts(both) and "A" in texts(both)


def many(n=40):
    """Temperatures and fractions of points in two classes, each with its error."""
    rng = np.random.default_rng(6)
    kelvin = Series(rng.uniform(9_000, 12_000, n), np.full(n, 250.0))
    share = Series(rng.uniform(0.1, 0.4, n), rng.uniform(0.01, 0.03, n))
    return kelvin, share, np.arange(n, dtype=float) % 2


def test_the_fraction_of_lithium_has_vertical_errors_and_names_of_classes_off_the_points(overlaps):
    kelvin, share, labels = many()
    with paper():
        figure = lithium_share_figure(
            kelvin, share, labels, names={0: "spodumene", 1: "lepidolite"}
        )
        axes = figure.axes[0]
        vertical = [np.array(bars.get_segments()) for bars in axes.collections]
        heights = np.concatenate([np.ptp(lines[..., 1], axis=1) for lines in vertical])

        assert sorted(heights[heights > 0]) == pytest.approx(sorted(2 * share.error), rel=1e-6)
        assert {"1 spodumene", "2 lepidolite"} <= set(texts(figure))
        assert axes.get_legend() is None and overlaps(figure) == []
        key = figure.legends[0].get_window_extent()
        assert not key.overlaps(axes.get_window_extent())


def test_one_wild_fraction_does_not_set_the_scale_and_is_said():
    kelvin, share, labels = many()
    share.value[7] = 40.0
    with paper():
        axes = lithium_share_figure(kelvin, share, labels).axes[0]

        assert axes.get_ylim()[1] < 0.5
        assert axes.get_ylabel().endswith("; 1 above")


def test_a_temperature_map_is_titled_with_its_errors(overlaps):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(12.0), np.arange(9.0)))
    kelvin = np.random.default_rng(8).normal(11_000, 200, len(x))
    kelvin[5] = 60_000.0
    with paper():
        figure = temperature_map_figure(
            {"": element_map(x, y, kelvin)}, "mm", np.linspace(200, 400, len(x))
        )
        said = "\n".join(texts(figure))

        assert "plasma temperature, median 10,988 K of 108 points" in said
        assert "standard error of a point: median ± 300 K, for two thirds ± 232 to 368 K" in said
        assert "plasma temperature (K); 1 above" in said
        assert overlaps(figure) == []


def test_the_strongest_peaks_are_labelled_though_nothing_explains_them(make_truth, overlaps):
    # Where no element has such lines: nothing may be named, and the highest are still told apart.
    places = (301.37, 412.91, 523.77)
    truth = make_truth([(900.0, nm, 0.05, 0.01) for nm in places])
    reduction = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity))
    with paper():
        figure = spectrum_figure(reduction)
        said = texts(figure)

        for nm in places:
            assert any(f"{nm:.1f}" in text for text in said)
        assert overlaps(figure) == []


def test_a_hot_channel_does_not_set_the_scale_of_a_spectrum_and_is_said(make_truth):
    truth = make_truth([(900.0, 412.91, 0.05, 0.01)])
    counts = truth.intensity.copy()
    counts[7_000] = 5e6
    reduction = reduce_spectrum(Spectrum(truth.wavelength_nm, counts))
    with paper():
        axes = spectrum_figure(reduction).axes

        assert max(one.get_ylim()[1] for one in axes) < 10_000
        assert axes[-1].get_xlabel().endswith("; bad channels, bridged: 1")


def test_a_hot_pixel_leaves_the_other_cells_their_colours():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(12.0), np.arange(9.0)))
    area = np.random.default_rng(8).uniform(5, 10, len(x))
    area[17] = 9_000.0
    with paper():
        figure = element_maps_figure({"Li": element_map(x, y, area)})
        mesh = figure.axes[0].collections[0]

        assert mesh.get_clim()[1] < 10.1
        assert any(text.endswith("; 1 above") for text in texts(figure))
