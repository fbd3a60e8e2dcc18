"""Every problem has a page, and its examples do what the page says."""

import re
from pathlib import Path

import pytest

import labrun.engine
from labrun.engine.check import CHECKS
from labrun.engine.problems.manual import (
    REFERENCE,
    WITHOUT_CHECK,
    all_codes,
    page,
    pages,
    reference_text,
    said_of,
)

SOURCE = Path(labrun.engine.__file__).parent


@pytest.mark.parametrize("code", sorted(all_codes()))
def test_a_page_says_why_and_its_examples_are_as_it_says(code):
    found = page(code)
    assert found is not None, f"{code} has no page"
    passing, failing = said_of(found, found.passes), said_of(found, found.fails)

    assert found.title and len(found.why) > 40
    assert [p.code for p in passing] == []
    assert {p.code for p in failing} == {code}
    assert {p.severity[0].upper() for p in failing} == {code[0]}


def test_every_page_is_that_of_a_code():
    assert set(pages()) == set(all_codes())


def test_no_code_belongs_to_two_families():
    families = {id(module): module for module, _ in WITHOUT_CHECK} | {id(c): c for c in CHECKS}
    codes = [code for module in families.values() for code in module.CODES]

    assert sorted(codes) == sorted(set(codes))


def test_every_code_that_the_engine_speaks_of_is_in_the_manual():
    spoken = {
        code
        for path in SOURCE.rglob("*.py")
        for code in re.findall(r'"([EW]\d{3})"', path.read_text(encoding="utf-8"))
    }

    assert spoken == set(all_codes())


def test_the_committed_reference_is_made_from_the_pages():
    committed = REFERENCE.read_text(encoding="utf-8")

    assert committed == reference_text(), "run `python -m labrun.engine.problems.manual`"


def test_a_page_shows_everything_that_its_examples_need():
    text = page("E231").text()

    assert text.startswith("E231: a parameter that a used protocol does not have\n")
    assert "Beside it, lift.yaml:\n\n    labrun: 1\n" in text
    assert "Fails with --bind stage=libs:" in page("E210").text()
