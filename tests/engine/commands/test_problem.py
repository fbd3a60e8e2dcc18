"""`labrun problem` prints the manual."""

from pathlib import Path

from ...command_line import labrun


def problem(*words):
    return labrun(Path(), "problem", *words)


def test_a_page_says_why_shows_both_examples_and_what_labrun_says():
    done = problem("E204")

    assert done.returncode == 0
    assert done.stdout.startswith("E204: a quantity of the wrong dimension\n")
    for words in ("Passes:", "Fails:", "4 s is a time, the device wants a length (mm)"):
        assert words in done.stdout


def test_without_a_code_all_are_listed():
    done = problem()

    assert done.returncode == 0
    assert "E101  text that is not YAML" in done.stdout
    assert "W402  a timeout shorter" in done.stdout


def test_case_and_brackets_do_not_matter_and_several_codes_may_be_asked():
    done = problem("e401", "[W402]")

    assert done.returncode == 0
    assert "E401: an id that is used twice" in done.stdout
    assert "W402: a timeout shorter" in done.stdout


def test_an_unknown_code_is_told_with_those_near_it():
    done = problem("E499")

    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("labrun: there is no problem E499; similar: E401 (")


def test_another_letter_or_none_finds_the_number():
    assert "similar: E204 (" in problem("W204").stderr
    assert "similar: E204 (" in problem("204").stderr


def test_a_word_finds_the_codes_that_speak_of_it():
    assert "W402 (a timeout shorter" in problem("timeout").stderr
    assert "`labrun problem` lists them all" in problem("xyzzy").stderr
