"""Values of the journal as people read them in comparisons and lists."""

import pytest

from labrun.engine.journal.encode import encode
from labrun.engine.progress import progress
from labrun.engine.run import came_to
from labrun.schemas.quantity import parse_quantity


@pytest.mark.parametrize("words", [came_to.value_text, progress.value_text])
@pytest.mark.parametrize("text", ["600 mm/min", "2 mL", "0.1 mol/L", "20 mm"])
def test_a_quantity_is_told_as_it_was_written(words, text):
    assert words(encode(parse_quantity(text))) == text
