"""The carets are under the error, whatever characters precede it."""

import io

import pytest

from labrun.engine.problems.print import print_problems
from labrun.schemas.problem import Problem


@pytest.mark.parametrize(
    ("line", "column", "length", "marks"),
    [
        ("a: bad", 4, 3, "   ^^^"),
        ("注意: bad", 5, 3, "      ^^^"),
        ("e\u0301: bad", 5, 3, "   ^^^"),
        ("a: 注意", 4, 2, "   ^^^^"),
        ("a:", 4, 1, "   ^"),
    ],
)
def test_carets_are_as_wide_as_what_they_mark(line, column, length, marks, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(line + "\n", encoding="utf-8")
    out = io.StringIO()
    problem = Problem(
        file=str(path), line=1, column=column, code="E101", message="bad", length=length
    )
    print_problems([problem], file=out)

    assert out.getvalue().splitlines()[2].partition("| ")[2] == marks
