"""Suggestions for mistyped names and words from other languages."""

import pytest

from labrun.engine.language.suggest import closest, did_you_mean, listed


@pytest.mark.parametrize(
    ("written", "options", "meant"),
    [
        ("tims", ["attempts", "time"], "time"),
        ("times", ["attempts", "wait"], "attempts"),
        ("ARGS", ["id", "with"], "with"),
        ("elif", ["if", "then", "else"], "else"),
        ("elif", ["if", "then"], "if"),
        ("until", ["parallel"], None),
        ("x" * 1000, ["x" * 999], None),
        ("nothing like it", ["move_to", "home"], None),
    ],
)
def test_the_nearest_name_or_the_word_that_means_the_same_is_found(written, options, meant):
    assert closest(written, options) == meant


def test_a_guess_is_the_end_of_a_sentence():
    assert did_you_mean("mov_to", ["move_to"], prefix="gantry.") == "; did you mean gantry.move_to?"
    assert did_you_mean("banana", ["move_to"]) == ""


def test_many_names_are_cut_short():
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert listed("abcde", limit=3) == "a, b, c and 2 more"
