"""The driver's `config:` in a lab, read and checked against the contract.

buttons: C:/labrun/buttons                       # of `labrun record-program --buttons`
actions:
  start:
    steps: [{click: name_field}, {type: "{sample}"}, {click: start}]
    proof: {new: C:/data, called: "*.raw"}       # or {shows: done}, {gone: busy}, {title: Finished}, ...
  save:
    steps: [{click: save}, {type: "C:/out/{name}.csv"}, {press: enter}]
    proof: {new: C:/out, called: "{name}.csv"}
    file: file                                   # the parameter and result that is that file
An action without steps is the probe of another one, or does nothing.
"""

from typing import Any

from pydantic import Field, ValidationError, model_validator

from ...schemas.contract import Contract
from ...schemas.model import Model
from ..driver import misfit
from .buttons import Step

PROOFS = ("new", "shows", "gone", "title", "reads")
KEPT_FOR_TEXTS = ("name",)


class Proof(Model):
    """What shows that an action is done: exactly one of the keywords.

    `new`: a folder in which one new file or folder appears that is called `called` and stays as it
    is; `shows`, `gone`: a recorded button; `title`: words in the title of one of its windows;
    `reads`: a control by name whose text is `says`, in which `*` stands for anything.
    """

    new: str | None = None
    called: str = "*"
    shows: str | None = None
    gone: str | None = None
    title: str | None = None
    reads: str | None = None
    says: str | None = None

    @model_validator(mode="after")
    def _one_word(self) -> "Proof":
        if sum(getattr(self, word) is not None for word in PROOFS) != 1:
            raise ValueError(f"a proof has one of {', '.join(PROOFS)}")
        if (self.reads is None) != (self.says is None):
            raise ValueError("`reads` names a control, and `says` the text that it has then")
        return self


class ActionSteps(Model):
    """How one action is done; `returns` are texts in which parameters and {name} are filled in."""

    steps: list[Step] = Field(default_factory=list)
    proof: Proof | None = None
    file: str | None = None
    returns: dict[str, str] = Field(default_factory=dict)
    within_s: float = Field(default=60, gt=0, le=3600)


class WindowProgramSettings(Model):
    """A program's window, and how each action of the contract is done in it."""

    buttons: str
    title: str | None = None
    actions: dict[str, ActionSteps]
    busy_s: float = Field(default=60, gt=0, le=600)
    dialog_s: float = Field(default=10, gt=0, le=120)
    settle_s: float = Field(default=1, gt=0, le=60)


def read_config(written: dict[str, Any], contract: Contract) -> WindowProgramSettings:
    """The configuration; raises ValueError with the first thing that is wrong, and where."""
    try:
        said = WindowProgramSettings.model_validate(written)
    except ValidationError as fault:
        raise misfit(fault) from fault
    probes = {action.probe for action in contract.actions.values()}
    for name in said.actions:
        if name not in contract.actions:
            known = ", ".join(contract.actions)
            raise ValueError(f"config.actions.{name}: {contract.type} has {known}")
    for name, action in contract.actions.items():
        one = said.actions.get(name)
        if one is None and name not in probes:
            raise ValueError(f"config.actions: {name} of {contract.type} has no steps")
        if one is not None and one.steps and one.proof is None and action.effect != "pure":
            raise ValueError(
                f"config.actions.{name}: it has no proof that it is done; write `proof:` with one of "
                f"{', '.join(PROOFS)}"
            )
        _check_texts(name, one, set(action.param_schemas()))
    return said


def _check_texts(name: str, one: ActionSteps | None, params: set[str]) -> None:
    """Every {word} in a text is a parameter of the action, or {name}."""
    if one is None:
        return
    filled = dict.fromkeys((*params, *KEPT_FOR_TEXTS), "1")
    proof = one.proof.model_dump(exclude_none=True).values() if one.proof else ()
    texts = [what for step in one.steps for _, what in step.words()]
    for text in (*texts, *proof, *one.returns.values()):
        try:
            text.format(**filled)
        except (KeyError, IndexError, ValueError) as fault:
            known = ", ".join(sorted(filled))
            raise ValueError(
                f"config.actions.{name}: {text!r} cannot be filled in ({fault}); it may hold {known}"
            ) from fault
