"""Lengths of time, sizes and values read as a person would say them."""

import pytest

from labrun.web.report.formatting import count, duration, moment, seconds_between, size, value


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0, "0 ms"), (0.0124, "12 ms"), (0.9996, "1.0 s"), (59.94, "59.9 s"), (59.96, "1 min 00 s"),
        (245, "4 min 05 s"), (3599.7, "1 h 00 min"), (7380, "2 h 03 min"), (273600, "3 d 04 h"),
    ],
)  # fmt: skip
def test_a_length_of_time_is_told_in_the_units_that_fit(seconds, words):
    assert duration(seconds) == words


@pytest.mark.parametrize(
    ("number", "words"),
    [(0, "0 B"), (999, "999 B"), (1000, "1.0 kB"), (999_960, "1.0 MB"), (12_000_000, "12.0 MB"),
     (3_400_000_000_000, "3.4 TB")],
)  # fmt: skip
def test_a_size_is_told_in_the_units_that_fit(number, words):
    assert size(number) == words


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"$quantity": [0.30000000000000004, "mm"]}, "0.3 mm"), ({"$quantity": [3, ""]}, "3"),
        ([{"$quantity": [1, "s"]}, "a"], "[1 s, a]"), (True, "yes"), (None, "none"),
        ({"a": 1.5}, "{a: 1.5}"),
    ],
)  # fmt: skip
def test_values_keep_their_unit_and_lose_the_noise_of_binary_fractions(told, words):
    assert value(told) == words


def test_counts_have_their_plural():
    assert [count(n, "hole") for n in (0, 1, 1071)] == ["0 holes", "1 hole", "1,071 holes"]


def test_a_clock_that_was_set_back_makes_no_negative_time():
    assert seconds_between("2026-11-21T08:00:01.000Z", "2026-11-21T08:00:00.000Z") == 0.0
    assert moment("2026-11-21T08:00:01.000Z") == "2026-11-21 08:00:01"
