"""Moments: read from text, the next one of a time of day, computed with, kept as JSON."""

from datetime import UTC, datetime, timedelta, timezone

import pytest

from labrun.engine.journal.encode import decode, encode
from labrun.engine.language.expression import Expression, ExpressionError
from labrun.engine.language.moments import next_moment, read_moment
from labrun.schemas.quantity import is_quantity, quantity_text

T = datetime(2026, 11, 24, 6, 30, tzinfo=timezone(timedelta(hours=1)))
NAMES = {"t": T, "u": T.astimezone(UTC) + timedelta(minutes=90), "n": "a"}


def value(text):
    found = Expression(text).evaluate(NAMES)
    return quantity_text(found) if is_quantity(found) else found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("u - t", "5400 s"), ("t + 90 min == u", True), ("90 min + t == u", True), ("u - 1.5 h == t", True),
        ("t < u and u >= t and t != u", True), ("max(t, u) == u", True), ("sorted([u, t])[0] == t", True),
        ("t in [u, t]", True), ("t + 0 == t", True), ("format(t, '%Y-%m-%d_%H%M')", "2026-11-24_0630"),
        ("format(t)", "2026-11-24T06:30:00+01:00"), ("t == 'a'", False), ("t - null", None),
    ],
)  # fmt: skip
def test_moments_are_computed_with(text, expected):
    assert value(text) == expected


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t + 5", "a moment needs a time"), ("t + 5 mm", "a moment needs a time"), ("t + t", "needs a"),
        ("5 s - t", "cannot be subtracted"), ("2 * t", "cannot be multiplied"), ("t < 5 s", "be compared"),
        ("t < 'a'", "cannot be compared"), ("format(t, '%n')", "not a format"), ("now()", "only known"),
        ("mean([t, u])", "not a number"), ("-t", "cannot be negated"),
    ],
)  # fmt: skip
def test_what_has_no_result_is_told_in_a_sentence(text, words):
    with pytest.raises(ExpressionError, match=words):
        value(text)


def test_a_time_of_day_is_the_next_one():
    now = datetime(2026, 11, 24, 6, 30).astimezone()

    assert next_moment("07:00", now) == now + timedelta(minutes=30)
    assert next_moment("6:30", now) == datetime(2026, 11, 25, 6, 30).astimezone()
    assert next_moment("06:30:10", now) == now + timedelta(seconds=10)
    assert next_moment("2026-11-24 07:00", now) == now + timedelta(minutes=30)
    assert next_moment("2020-01-01T07:00:00Z", now) < now
    assert next_moment(T, now) == T


@pytest.mark.parametrize(
    "said", ["24:00", "7", "noon", "2026-13-01 07:00", "2026-11-24", 7, None, True]
)
def test_what_is_no_time_of_day_is_refused(said):
    with pytest.raises(ValueError, match="is not a time of day"):
        next_moment(said, T)


def test_a_moment_comes_back_from_the_journal_as_it_was():
    assert decode(encode({"t": [T]})) == {"t": [T]}
    assert read_moment("2026-11-24 06:30:00+01:00") == T
