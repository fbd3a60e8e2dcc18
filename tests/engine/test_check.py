"""Every kind of fault is reported with its code at its place; valid protocols pass."""

import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from labrun.engine.check import Checked, check_file, check_text
from labrun.engine.problems.manual import all_codes
from labrun.schemas.protocol import STEP_KINDS

HERE = Path(__file__).parent
FAULTY = sorted(path for path in (HERE / "faulty").iterdir() if path.suffix in (".yaml", ".json"))
EXAMPLE = HERE / "examples" / "libs_grid_scan.yaml"
WAY_ON = re.compile(r"# way on: (.*)")
EXPECTED = re.compile(r"expect: ([^\n\"]*?)(?: with (-[^\n\"]*))?[\n\"]")


def told(checked: Checked, file: Path | None = None) -> list[str]:
    """`E204 9:10` for each problem; for another file, its name precedes the place."""
    name = str(file) if file is not None else ""
    return [
        f"{p.code} {f'{Path(p.file).name}:' * (bool(name) and p.file != name)}{p.line}:{p.column}"
        for p in checked.problems
    ]


def expected(path: Path) -> tuple[list[str], dict[str, Any]]:
    """What a file of the corpus declares in its header: problems and command line options.

    `# expect: E209 5:38 with --lab beside/lab.yaml -p depth=2`; `# way on: TEXT` must be in one of them.
    """
    match = EXPECTED.search(path.read_text(encoding="utf-8", errors="replace"))
    assert match, f"{path.name} does not say what to expect"
    words = (match[2] or "").split()
    options: dict[str, Any] = {"needed": "-p" in words}
    for option, value in zip(words[::2], words[1::2], strict=True):
        if option == "--lab":
            options["lab"] = path.parent / value
        else:
            name, _, text = value.partition("=")
            options.setdefault({"-p": "params", "--bind": "bind"}[option], {})[name] = text
    return sorted(match[1].split(", ")), options


@pytest.mark.parametrize("path", FAULTY, ids=lambda path: path.stem)
def test_each_faulty_protocol_is_told_its_fault_at_its_place_and_nothing_else(path):
    problems, options = expected(path)
    checked = check_file(path, **options)
    ways = WAY_ON.findall(path.read_text(encoding="utf-8", errors="replace"))

    assert sorted(told(checked, path)) == problems
    assert all(any(way in f"{p.message} = {p.hint}" for p in checked.problems) for way in ways)


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


def test_a_misspelt_section_is_told_once_and_not_at_every_step():
    text = EXAMPLE.read_text(encoding="utf-8")

    assert told(check_text(text.replace("\nsteps:", "\nstesp:"), "p")) == ["E110 22:1"]
    assert told(check_text(text.replace("\ndevices:", "\ndevises:"), "p")) == ["E110 14:1"]
    assert told(check_text(text.replace("foreach:", "for_each:"), "p")) == ["E114 34:5"]


def test_the_corpus_has_every_code_at_least_twice_and_every_kind_of_step():
    problems = [expected(path)[0] for path in FAULTY]
    counts = Counter(code for one in problems for code in {told[:4] for told in one})
    text = "\n".join(path.read_text(encoding="utf-8", errors="replace") for path in FAULTY)
    rare = [code for code in all_codes() if counts[code] < 2 and code not in RARE]

    assert rare == []
    assert set(counts) <= set(all_codes())
    assert len(FAULTY) >= 260
    assert [kind.KIND for kind in STEP_KINDS if f"{kind.KIND}:" not in text] == []


RARE = {"E122", "E130", "E131", "E132", "W130", "W131", "W133"}
"""E122 needs many files; labs are covered by test_lab.py and the manual."""
