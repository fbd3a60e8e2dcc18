"""When a run will end."""

from labrun.web.runs.counts import Table
from labrun.web.runs.pace import eta


def test_a_loop_that_is_over_says_nothing_of_the_end():
    table = Table("main/scan", "", total=5)
    for i in range(4):
        table.end(table.touch(str(i), 0, i), i, "ok", i, "")
    before = eta(table)
    table.end(table.touch("4", 0, 4), 4, "ok", 4, "")

    assert before is not None and before[0] <= before[1]
    assert eta(table) is None
