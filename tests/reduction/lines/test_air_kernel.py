import numpy as np
import pytest

from labrun.reduction.lines.air import to_air
from labrun.reduction.lines.air_kernel import in_air


@pytest.mark.parametrize("nm", [190.0, 199.99, 200.0, 589.158, 961.0])
def test_one_by_one_is_as_all_at_once(nm):
    assert in_air(nm) == pytest.approx(float(to_air(np.array(nm))), abs=1e-12)
