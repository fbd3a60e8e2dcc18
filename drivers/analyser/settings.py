"""Read a driver's configuration as a model, and report what is wrong with it in plain words."""

from typing import TypeVar

from pydantic import BaseModel, ValidationError

from ..driver import Place
from ..find import DriverFault

M = TypeVar("M", bound=BaseModel)


def settings_of(place: Place, model: type[M]) -> M:
    """The lab's `config` as `model`; raises DriverFault with every complaint."""
    try:
        return model.model_validate(place.config)
    except ValidationError as fault:
        raise DriverFault("; ".join(_complaints(fault, model))) from fault


def _complaints(fault: ValidationError, model: type[BaseModel]) -> list[str]:
    known = ", ".join(model.model_fields)
    found = []
    for error in fault.errors():
        place = "config." + ".".join(str(part) for part in error["loc"])
        words = {
            "missing": f"{place} is missing",
            "extra_forbidden": f"{place} is unknown; the known keys are {known}",
        }.get(error["type"], f"{place}: {error['msg']}")
        found.append(words)
    return found
