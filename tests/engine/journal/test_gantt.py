"""A Gantt chart keeps every second of work, wherever its columns lie and however long it grows."""

import random

import pytest

from labrun.engine.journal.gantt import Gantt, marks


def test_no_second_is_lost_while_the_columns_grow_wider():
    drawn, chart, at_s = random.Random(5), Gantt(), 0.0
    busy = {"gantry.move_to": 0.0, "libs.measure": 0.0, "gantry.home": 0.0}
    for _ in range(500):
        label, took_s = drawn.choice(list(busy)), drawn.expovariate(1 / 7)
        chart.add(label, at_s, at_s + took_s)
        busy[label] += took_s
        at_s += took_s + drawn.random()
    rows = chart.rows(120, at_s)

    assert {label: sum(row) * at_s / 120 for label, row in rows.items()} == pytest.approx(
        busy, rel=0.01
    )
    assert [label.partition(".")[0] for label in rows] in (
        ["gantry", "gantry", "libs"],
        ["libs", "gantry", "gantry"],
    )


def test_it_is_drawn_where_it_was():
    chart = Gantt()
    chart.add("a.x", 0, 25)
    chart.add("b.y", 25, 70)
    chart.add("b.y", 80, 85)

    assert chart.rows(10, 100) == {
        "a.x": pytest.approx([1, 1, 0.5, *[0] * 7], abs=0.02),
        "b.y": pytest.approx([0, 0, 0.5, 1, 1, 1, 1, 0, 0.5, 0], abs=0.02),
    }


def test_a_part_of_the_time_is_looked_at_alone():
    chart = Gantt(20, 40)
    for began_s in (0, 25, 38, 60):
        chart.add("a.x", began_s, began_s + 5)

    assert chart.rows(4, 100) == {"a.x": pytest.approx([0, 1, 0, 0.4], abs=0.02)}
    assert Gantt(20, 40).span_s(30) == 10


def test_an_axis_has_few_round_marks_of_any_length():
    assert marks(0, 5.2, 6) == [
        (0, "0"),
        (1, "1 s"),
        (2, "2 s"),
        (3, "3 s"),
        (4, "4 s"),
        (5, "5 s"),
    ]
    assert marks(180, 120, 6) == [
        (180, "3 min"),
        (210, "3:30 min"),
        (240, "4 min"),
        (270, "4:30 min"),
    ]
    assert [words for _, words in marks(0, 4.1 * 3600, 6)] == ["0", "1 h", "2 h", "3 h", "4 h"]
    assert [words for _, words in marks(0, 2.4 * 3600, 6)] == [
        "0",
        "30 min",
        "1 h",
        "1:30 h",
        "2 h",
    ]
    for days in (3, 40, 400, 4000):
        assert 1 <= len(marks(0, days * 86400, 6)) <= 6
