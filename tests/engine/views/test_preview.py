"""`labrun preview` follows a protocol's points before anything moves."""

from pathlib import Path

import pytest

from labrun.engine.check import check_file, check_text
from labrun.engine.commands.preview import outside_text
from labrun.engine.views.forecast import outlook
from labrun.engine.views.preview.figure import draw, preview_figure
from labrun.engine.views.preview.plane import Area, moves_in_plane, plane_of
from labrun.engine.views.preview.walk import Walk
from labrun.schemas.contracts import shipped_contracts

HERE = Path(__file__).parents[1]
EXAMPLE = HERE / "examples" / "libs_grid_scan.yaml"
PROTOCOLS = HERE.parents[1] / "protocols"
HEADER = "labrun: 1\nname: t\ndevices: {gantry: gantry@1, libs: libs_analyzer@1}\nsteps:\n"


def walk(steps: str, most: int = 1000) -> Walk:
    checked = check_text(HEADER + steps, "t.yaml")
    assert checked.protocol is not None
    return Walk(most=most).follow(outlook(checked))


def points(found: Walk) -> list[tuple[float, float]]:
    return [(one.x_mm, one.y_mm) for one in found.paths["gantry"].points]


def test_the_points_of_the_example_are_its_grid_in_order():
    found = Walk().follow(outlook(check_file(EXAMPLE)))
    path = found.paths["gantry"]

    assert points(found)[:2] == [(0, 0), (0.2, 0)] and points(found)[21] == (4, 0.2)
    assert len(path.points) == 1071 and path.length_mm == pytest.approx(214)
    assert path.outside == [] and found.notes == [] and not found.full


def test_only_actions_that_move_in_a_plane_count():
    contracts = shipped_contracts()

    assert moves_in_plane(contracts["gantry@1"], "move_to")
    assert not moves_in_plane(contracts["gantry@1"], "home")
    assert not moves_in_plane(contracts["depth_camera@1"], "calibrate")
    assert not moves_in_plane(contracts["balance@1"], "weigh")


def test_the_area_is_that_of_the_contract_narrowed_by_the_lab(tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "devices: {g: {contract: gantry@1, driver: sim_gantry, "
        "limits: {x: {maximum: 1 cm}, y: {minimum: 5}}}}\n"
    )
    protocol = tmp_path / "p.yaml"
    protocol.write_text(
        "labrun: 1\nname: p\ndevices: {gantry: gantry@1}\n"
        "steps: [{do: gantry.move_to, with: {x: 2 cm, y: 6}}]\n"
    )
    checked = check_file(protocol, lab=lab)
    plane = plane_of(checked.roles["gantry"])
    path = Walk().follow(outlook(checked)).paths["g"]

    assert plane is not None and plane.area == Area((0, 10), (5, 810))
    assert path.outside == [0]
    assert outside_text(path) == (
        "g: 1 of 1 point is outside x 0..10 mm, y 5..810 mm; the first is number 1, (20, 6) mm"
    )


def test_axes_that_are_left_out_stay():
    found = walk(
        "  - {do: gantry.move_to, with: {x: 1 cm, y: 2}}\n"
        "  - {do: gantry.move_to, with: {z: 3}}\n"
        "  - {do: gantry.move_to, with: {y: 5}}\n"
    )

    assert points(found) == [(10, 2), (10, 5)] and found.paths["gantry"].length_mm == 3


def test_homing_ends_the_path_and_what_only_the_run_knows_is_counted():
    found = walk(
        "  - {do: gantry.move_to, with: {x: 1, y: 2}}\n"
        "  - {id: h, do: gantry.move_to, with: {x: 4, y: 6}}\n"
        "  - {do: gantry.home}\n"
        "  - {do: gantry.move_to, with: {x: 1, y: 2}}\n"
        '  - {do: gantry.move_to, with: {x: "${{ steps.h.x }}"}}\n'
    )
    path = found.paths["gantry"]

    assert points(found) == [(1, 2), (4, 6), (1, 2)]
    assert path.length_mm == 5 and path.unknown == 1


def test_nested_loops_branches_and_turns_are_followed():
    found = walk("""\
  - set: {x: "${{ 0 mm }}"}
  - foreach: {i: [1, 2]}
    steps:
      - foreach: {j: "${{ range(i) }}"}
        steps: [{do: gantry.move_to, with: {x: "${{ i * 10 mm }}", y: "${{ j * 1 mm }}"}}]
      - {if: "${{ i == 2 }}", then: [{do: gantry.move_to, with: {x: 0, y: 0}}]}
  - while: ${{ x < 2 mm }}
    max: 9
    steps:
      - set: {x: "${{ x + 1 mm }}"}
      - {do: gantry.move_to, with: {x: "${{ x }}", y: 9}}
""")

    assert points(found) == [(10, 0), (20, 0), (20, 1), (0, 0), (1, 9), (2, 9)]
    assert found.notes == []


def test_what_the_run_decides_is_drawn_and_said():
    found = walk("""\
  - {id: shoot, do: libs.measure}
  - if: ${{ steps.shoot.shot_id == 'a' }}
    then: [{do: gantry.move_to, with: {x: 1, y: 1}}]
    else: [{do: gantry.move_to, with: {x: 2, y: 2}}]
  - {do: gantry.move_to, with: {x: 3, y: 3}, when: "${{ run.simulated }}"}
  - {while: "${{ steps.shoot.shot_id == 'b' }}", max: 2, steps: [{do: gantry.move_to, with: {x: 4, y: 4}}]}
""")

    assert points(found) == [(1, 1), (2, 2), (3, 3), (4, 4)]
    assert len(found.notes) == 3


def test_a_very_long_loop_is_drawn_as_far_as_the_bound():
    found = walk(
        '  - foreach: {i: "${{ range(1000000) }}"}\n'
        '    steps: [{do: gantry.move_to, with: {x: "${{ i * 0.0001 mm }}", y: 0}}]\n',
        most=50,
    )

    assert found.full and len(points(found)) == 50


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_the_figure_is_written_in_the_format_of_its_suffix(tmp_path, suffix):
    found = Walk().follow(outlook(check_file(PROTOCOLS / "pegmatite_map.yaml")))
    file = tmp_path / f"map.{suffix}"
    draw(found, "a $map$", file)
    begin = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]

    assert file.read_bytes().startswith(begin)


def test_the_figure_says_counts_path_limits_and_what_is_outside():
    checked = check_file(PROTOCOLS / "pegmatite_map.yaml", params={"x0": "727 mm"})
    figure = preview_figure(Walk().follow(outlook(checked)), "pegmatite-map")
    main, *others = figure.axes
    said = [text.get_text() for text in (*figure.texts, *main.texts)]

    assert main.get_title(loc="left") == "1,071 points, path 214.0 mm"
    assert "255 outside x 0..730 mm, y 0..810 mm (red)" in said
    assert "White: where gantry may go, x 0..730 mm, y 0..810 mm." in said
    assert main.get_aspect() == 1 and main.get_xlabel() == "x (mm)"
    assert "on the bench (mm)" in [axes.get_title(loc="left") for axes in others]


def test_several_loops_have_a_legend_and_several_devices_a_panel_each():
    found = walk(
        '  - {id: a, foreach: {i: [0, 1]}, steps: [{do: gantry.move_to, with: {x: "${{ i }}", y: 0}}]}\n'
        '  - {id: b, foreach: {i: [0, 9]}, steps: [{do: gantry.move_to, with: {x: "${{ i }}", y: 3}}]}\n'
    )
    legend = preview_figure(found, "t").legends[0]
    two = Walk().follow(outlook(check_file(PROTOCOLS / "two_station.yaml")))

    assert [text.get_text() for text in legend.get_texts()][:2] == ["a", "b"]
    assert list(two.paths) == ["gantry", "gantry_b"]
    assert sum(axes.get_xlabel() == "x (mm)" for axes in preview_figure(two, "t").axes) == 2
