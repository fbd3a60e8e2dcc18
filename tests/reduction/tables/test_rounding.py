import numpy as np
import pytest

from labrun.reduction.tables.columns import number
from labrun.reduction.tables.rounding import rounded, significant


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (123456.789, 4, "123500.0"),
        (0.000123456, 3, "0.000123"),
        (-2.5e-9, 1, "-2e-09"),
        (9.9996, 4, "10.0"),
        (1e22, 5, "1e+22"),
        (0.0, 3, "0.0"),
        (1 / 3, 5, "0.33333"),
    ],
)
def test_so_many_significant_digits_are_the_nearest_double_of_a_short_decimal(value, digits, text):
    assert repr(float(significant(np.array([value]), digits)[0])) == text


def test_rounded_numbers_are_short_over_many_decades():
    values = 10 ** np.random.default_rng(1).uniform(-12, 12, 5000)
    texts = [repr(v) for v in significant(values, 6).tolist()]

    assert max(len(text.partition("e")[0].replace(".", "").strip("0")) for text in texts) <= 6


def test_decimals_leave_no_minus_before_a_nought():
    told = rounded([-0.00001, 1.23456, np.inf, np.nan], number("x", decimals=2))

    assert [str(v) for v in told.tolist()] == ["0.0", "1.23", "nan", "nan"]


def test_what_is_given_is_not_changed():
    given = np.array([1.23456, np.inf])
    rounded(given, number("x", decimals=2))

    assert given.tolist() == [1.23456, np.inf]
