"""Values that do not depend on any parameter; not a check, but a helper of several checks."""

from typing import Any

from ..language.expression import ExpressionError
from ..language.fold import Folded, Folding, fold
from ..language.value import value_of

NOTHING = Folding({}, {}, {})


def constant(raw: Any) -> Folded:
    """The value, if it needs no parameter, result or name."""
    try:
        return fold(value_of(raw), NOTHING)
    except ExpressionError:
        return Folded(known=False)


def always(raw: Any) -> bool:
    """True for a condition that is never false, such as `${{ true }}`."""
    found = constant(raw)
    return found.known and not isinstance(found.value, str) and bool(found.value)


def never(raw: Any) -> bool:
    """True for a condition that is never true."""
    found = constant(raw)
    return found.known and not isinstance(found.value, str | None) and not found.value


def fixed_count(raw: Any) -> int | None:
    """A fixed number of iterations; None where it is not fixed or not a valid count."""
    found = constant(raw)
    is_count = found.known and type(found.value) is int and found.value >= 0
    return found.value if is_count else None
