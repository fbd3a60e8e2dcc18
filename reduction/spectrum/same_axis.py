"""What follows from the wavelengths alone is worked out once for spectra that share them.

And what follows from the counts alone, once for steps that share them.
"""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from .kernel import kernel
from .spectrum import FloatArray

T = TypeVar("T")


def of_axis(function: Callable[[FloatArray], T]) -> Callable[[FloatArray], T]:
    """Keep the answer for the last axis, which nobody may change: a folder of spectra has one."""
    last: list[tuple[FloatArray, T]] = []

    @wraps(function)
    def answer(x: FloatArray) -> T:
        for before, told in last[:]:
            if len(before) == len(x) and _same(before, x):
                return told
        told = function(x)
        last[:] = [(x.copy(), told)]
        return told

    return answer


@kernel
def _same(before, x):
    differ = 0  # counted to the end: several at once, which is faster than to stop at the first
    for i in range(len(before)):
        differ += before[i] != x[i]
    return differ == 0
