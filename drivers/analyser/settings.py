"""Read a driver's configuration as a model, and report what is wrong with it in plain words."""

from collections.abc import Iterator
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from ..driver import Misfit, Place, check_keys

M = TypeVar("M", bound=BaseModel)


def settings_of(place: Place, model: type[M]) -> M:
    """The lab's `config` as `model`; raises UnknownKey, or Misfit with every complaint."""
    check_keys(model.model_fields, place.config)
    try:
        return model.model_validate(place.config)
    except ValidationError as fault:
        first = fault.errors()[0]["loc"]
        raise Misfit("; ".join(_complaints(fault)), first) from fault


def _complaints(fault: ValidationError) -> Iterator[str]:
    for error in fault.errors():
        place = "config." + ".".join(str(part) for part in error["loc"])
        yield f"{place} is missing" if error["type"] == "missing" else f"{place}: {error['msg']}"
