"""Rows of the table of semantics that say all in one line: a protocol, and what its run leaves behind."""

import pytest


def table(*rows):
    """A test for each (name, `case -> what happens`, protocol, what it leaves behind, how it is run).

    What it leaves behind: attributes of `Ran` or of the journal's last record, and part of the `reason`.
    """

    @pytest.mark.parametrize(
        ("body", "left", "how"),
        [pytest.param(body, left, dict(*how), id=name) for name, _, body, left, *how in rows],
    )
    def test(compare, body, left, how):
        compare(body, left, how)

    return test
