"""For protocols of the corpus that call a function of their own."""

from typing import Annotated


def drift(masses: list[Annotated[float, "g"]]) -> Annotated[float, "g"]:
    return max(masses) - min(masses)


def untyped(x):
    return x
