"""What a changed protocol means for finished work, as the page says it."""

from labrun.engine.check import check_text
from labrun.web.runs.compare_work import grouped
from labrun.web.runs.outline import Outline

TEXT = """\
labrun: 1
name: scan
devices: {libs: libs_analyzer@1}
steps:
  - {id: first, do: libs.measure}
  - {id: scan, foreach: {i: "${{ range(9) }}"}, steps: [{id: shoot, do: libs.measure}]}
"""


def test_each_change_is_told_once_with_its_points():
    outline = Outline(check_text(TEXT, "scan.yaml"))
    found = [("z 1 -> 2", f"main/scan/{i}/shoot") for i in range(5)]

    assert grouped(outline, [*found, ("z 1 -> 2, too", "main/first"), ("gone", "main/gone")]) == [
        "z 1 -> 2 (at 0 · 1 · 2 and 2 more)", "z 1 -> 2, too", "gone",
    ]  # fmt: skip
