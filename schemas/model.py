"""The base that every model here is built on: closed, frozen, named as in YAML."""

from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError


class Model(BaseModel):
    """Unknown keys are errors, values do not change after they have been read."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True,
        defer_build=True,  # many models refer to each other: built when first used, not at start-up
    )  # fmt: skip


def no_items() -> list[Any]:
    """The default of a list; to read the signature of `list` pydantic needs a tokenizer, 2 % of a check."""
    return []


def first_fault(fault: ValidationError) -> str:
    """`actions.go.timeout: ...`: the first thing that is wrong, and where."""
    first = fault.errors()[0]
    return f"{'.'.join(str(part) for part in first['loc']) or 'all of it'}: {first['msg']}"
