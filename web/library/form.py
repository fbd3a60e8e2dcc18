"""The form before a run: parameters, roles, hazards, and questions to the operator."""

from collections.abc import Iterator, Sequence

from ...engine.check import Checked
from ...engine.language.shape import Place
from ...engine.views.forecast import Outlook, outlook
from ...engine.views.words.speak import spoken
from ...schemas import protocol as p
from ...schemas.quantity import is_quantity, quantity_text
from ..models.protocols import Hazard, ParamForm, RoleForm
from .pointer import pointer_text


def params_of(protocol: p.Protocol | None) -> list[ParamForm]:
    """The parameters in the order of the protocol."""
    if protocol is None:
        return []
    return [_param(name, param) for name, param in protocol.params.items()]


def _param(name: str, param: p.Param) -> ParamForm:
    return ParamForm.of(
        param, name=name, default=_plain(param.default), required=param.default is None,
        minimum=_plain(param.minimum), maximum=_plain(param.maximum),
        enum=None if param.enum is None else [_plain(one) for one in param.enum],
    )  # fmt: skip


def _plain(value: object) -> object:
    return quantity_text(value) if is_quantity(value) else value


def roles_of(checked: Checked) -> list[RoleForm]:
    """Each role with the devices of the lab that could play it."""
    if checked.protocol is None or checked.lab is None:
        return []
    devices = checked.lab.lab.devices
    return [
        RoleForm(
            role=role, contract=contract,
            device=checked.roles[role].device if role in checked.roles else None,
            choices=[name for name, device in devices.items() if device.contract == contract],
        )
        for role, contract in checked.protocol.devices.items()
    ]  # fmt: skip


def hazards_of(checked: Checked) -> list[Hazard]:
    """Every dangerous action except plain motion, at its first occurrence."""
    found: dict[tuple[str, str], Hazard] = {}
    survey = checked.survey
    for step, at, bound, action in survey.actions() if survey is not None else ():
        if action.danger in (None, "motion"):
            continue
        name = step.do.partition(".")[2]
        hazard = Hazard(
            danger=action.danger or "", device=bound.device, action=name,
            pointer=pointer_text(list(at.place)),
        )  # fmt: skip
        found.setdefault((bound.device, name), hazard)
    return list(found.values())


def questions_of(checked: Checked) -> list[str]:
    """Questions that the operator of this lab will or may be asked, in the order of the protocol."""
    if checked.protocol is None or checked.survey is None:
        return []
    view = outlook(checked)
    if checked.lab is not None:
        view = view.bound(run={"simulated": checked.lab.lab.simulated})
    return list(_questions(view, checked.protocol.steps, ("steps",)))


def _questions(view: Outlook, steps: Sequence[p.Step], place: Place) -> Iterator[str]:
    for index, step in enumerate(steps):
        at = (*place, index)
        if step.when is not None and view.truth(step.when, (*at, "when")) is False:
            continue
        if isinstance(step, p.Confirm):
            yield spoken(view, step.confirm, (*at, "confirm"))
        elif isinstance(step, p.Ask):
            yield spoken(view, step.ask, (*at, "ask"))
        truth = view.truth(step.if_, (*at, "if")) if isinstance(step, p.If) else None
        for key, inner in p.inner_lists(step):
            if truth is None or (key == "then") is truth:
                yield from _questions(view, inner, (*at, key))
