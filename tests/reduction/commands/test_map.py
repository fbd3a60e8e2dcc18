import pytest

GRID = "x,y,Li,H\n" + "".join(
    f"{x},{y},{5 * (x > 1) + 0.1 * y},{3 * (y > 1) + 0.1 * x}\n" for x in range(4) for y in range(4)
)


def data(tmp_path, text):
    (tmp_path / "run").mkdir(exist_ok=True)
    (tmp_path / "run" / "data.csv").write_text(text)


@pytest.mark.slow
def test_a_run_gets_maps_classes_and_a_table_to_read(tmp_path, labrun):
    data(tmp_path, GRID)
    done = labrun("map", "run", "-o", "out", "--format", "pdf")

    assert done.returncode == 0, done.stderr
    assert "4 classes from Li, H, number chosen by silhouette" in done.stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "maps.csv", "classes.csv", "class_summary.csv", "map.json", "element_maps.pdf",
        "class_map.pdf", "classes.pdf",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        (GRID, ["--elements", "Zr"], "no area of Zr here, only of H, Li"),
        (GRID, ["--elements", "Xx"], "'Xx' is not an element symbol"),
        (GRID, ["--features", ","], "names no element"),
        (GRID, ["--scale", "log"], "--scale log: choose one of min-max, absolute, total"),
        (GRID, ["--format", "gif"], "--format gif: choose one of png, svg, pdf"),
        ("key,Li\na,1\n", [], "no coordinates"),
        ("x,y,Li\n0,0,\n1,1,nan\n", [], "no numeric area"),
        ("x,y,Li\n0,0,0\n1,1,0\n", [], "every area in it is 0"),
        ("\x00\x01", [], "no row"),
    ],
)
def test_what_cannot_be_done_is_a_sentence(tmp_path, labrun, text, words, said):
    data(tmp_path, text)
    done = labrun("map", "run", *words)

    assert done.returncode == 2
    assert said in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "said", "figure"),
    [
        ("x,y,Li\n0,0,5\n", "one point: a table but no map", None),
        ("x,y,Li\n0,0,5\n1,1,5\n2,2,5\n", "one class", "line_scan.png"),
        ("x,Li,K\n0,1,2\n1,x,4\n2,5,1\n", "not a number, such as 'x'", "line_scan.png"),
        ("sample,x,y,Li\nA,0,0,1\nA,1,0,2\nA,0,1,9\nB 2,0,0,1\nB 2,1,0,5\nB 2,0,1,3\n", "",
         "element_maps_B-2.png"),
        ("x,y,Li_wt_percent\n" + "".join(f"{x},{y},{x}\n" for x in range(4) for y in (0, 1)),
         "Li grade 1.5 ± ", "grade.png"),
        ("x,y,Li\n0,0,1\n0,0,3\n1,0,4\n0,1,9\n", "measured more than once", "element_maps.png"),
    ],
)  # fmt: skip
def test_odd_points_are_drawn_as_far_as_they_go(tmp_path, labrun, text, said, figure):
    data(tmp_path, text)
    done = labrun("map", "run")
    made = {path.name for path in (tmp_path / "run" / "maps").iterdir()}

    assert done.returncode == 0, done.stderr
    assert said in done.stderr
    assert "maps.csv" in made and (figure is None or figure in made)


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path, labrun):
    data(tmp_path, GRID)
    (tmp_path / "file").write_text("")
    done = labrun("map", "run", "-o", "file/below")

    assert done.returncode == 1
    assert "Traceback" not in done.stderr and "below" in done.stderr
