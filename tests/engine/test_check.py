"""Every kind of fault is told with its code at its place; what is in order passes."""

import re
from pathlib import Path

import pytest

from labrun.engine.check import CHECKS, Checked, check_file, check_text
from labrun.engine.manual import all_codes, page

HERE = Path(__file__).parent
FAULTY = sorted((HERE / "faulty").glob("*.yaml"))
EXAMPLE = HERE / "examples" / "libs_grid_scan.yaml"


def told(checked: Checked) -> list[str]:
    return [f"{p.code} {p.line}:{p.column}" for p in checked.problems]


@pytest.mark.parametrize("path", FAULTY, ids=lambda path: path.stem)
def test_each_faulty_protocol_is_told_its_fault_at_its_place_and_nothing_else(path):
    first = path.read_text(encoding="utf-8").splitlines()[0]
    expected = sorted(first.removeprefix("# expect: ").split(", "))

    assert sorted(told(check_file(path))) == expected


def test_the_example_checks_clean():
    checked = check_file(EXAMPLE)

    assert checked.problems == []
    assert checked.ok
    assert checked.roles["reduce"].device == "reduce"
    assert f"{checked.params['pitch']:~}" == "0.2 mm"


def test_all_problems_of_a_file_are_told_at_once_sorted_by_place():
    text = EXAMPLE.read_text(encoding="utf-8")
    for right, wrong in (
        ("libs.locate ", "libs.locat "),
        ("steps.shoot.shot_id", "steps.shoot.shotid"),
        ("- do: gantry.home\n        timeout", "- doo: gantry.home\n        timeout"),
        ("default: 10 mm,", "default: 10 s,"),
    ):
        assert right in text
        text = text.replace(right, wrong, 1)
    checked = check_text(text, "broken.yaml")
    places = [(p.line, p.column) for p in checked.problems]

    assert {"E114", "E202", "E221", "E301"} <= {p.code for p in checked.problems}
    assert places == sorted(places)
    assert not checked.ok


def pages() -> list[tuple[str, str, list[str]]]:
    """(family, protocol, codes) from the docstring of every check."""
    found = []
    for family in CHECKS:
        document = family.__doc__ or ""
        name = family.__name__.rpartition(".")[2]
        passing, _, failing = document.partition("\nFails")
        codes = re.findall(r"[EW]\d{3}", failing.partition(":\n")[0])
        for part, wanted in ((passing, []), (failing, codes)):
            lines = re.findall(r"^    .*$|^$", part[part.index("\n    ") :], re.MULTILINE)
            found.append((name, "\n".join(line[4:] for line in lines).strip() + "\n", wanted))
    return found


@pytest.mark.parametrize(("family", "text", "codes"), pages())
def test_the_manual_pages_tell_the_truth(family, text, codes):
    problems = check_text(text, "page.yaml").problems

    assert sorted(p.code for p in problems) == sorted(codes)


def test_a_misspelt_section_is_told_once_and_not_at_every_step():
    text = EXAMPLE.read_text(encoding="utf-8")

    assert told(check_text(text.replace("\nsteps:", "\nstesp:"), "p")) == ["E110 22:1"]
    assert told(check_text(text.replace("\ndevices:", "\ndevises:"), "p")) == ["E110 14:1"]
    assert told(check_text(text.replace("foreach:", "for_each:"), "p")) == ["E114 34:5"]


def test_every_code_has_its_place_in_the_manual():
    used = {p.code for path in FAULTY for p in check_file(path).problems}

    assert used <= set(all_codes())
    assert "Passes" in (page("E204") or "")
    assert page("E999") is None


def test_every_code_belongs_to_one_family_and_is_in_the_corpus_or_on_a_page():
    owners = [code for family in CHECKS for code in family.CODES]
    seen = {word for path in FAULTY for word in re.findall(r"[EW]\d{3}", path.read_text())}
    seen |= {code for _, _, codes in pages() for code in codes} | {"W401"}

    assert len(owners) == len(set(owners))
    assert set(owners) - seen == set()
