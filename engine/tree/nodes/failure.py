"""Why a step failed, as it travels up the ladder retry, fallback, on_error, keep_going, finally."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ....schemas.contract import Happened

if TYPE_CHECKING:
    from ...run.frame import Frame


@dataclass(frozen=True, slots=True)
class Failure:
    """One failure; `error` in expressions.

    `skip`: a person chose to leave this iteration out. `stop`: a person chose to end the run;
    nothing above may continue then. `bygone`: the point that an earlier session had reached when it
    turned to another branch. `anew`: what had succeeded then, and was repeated, fails now. `where`,
    `tries` and `limit` say for people in which iterations, after how many attempts, and past which
    limit of a loop. `others`: further failures of a `finally`, which has run on.
    """

    name: str
    message: str
    step: str = ""
    device: str = ""
    action: str = ""
    happened: Happened = "no"
    once: bool = False
    skip: bool = False
    stop: bool = False
    bygone: bool = False
    anew: bool = False
    where: tuple[str, ...] = ()
    tries: int = 1
    limit: str = ""
    others: tuple["Failure", ...] = ()

    def as_error(self) -> dict[str, Any]:
        """What `error` holds in an expression."""
        return {
            "name": self.name,
            "message": self.message,
            "step": self.step,
            "device": self.device,
            "action": self.action,
        }

    @classmethod
    def from_error(cls, error: dict[str, Any]) -> "Failure":
        """Recreate a failure from what `as_error` gave."""
        told = {
            key: str(error.get(key, "")) for key in ("name", "message", "step", "device", "action")
        }
        return cls(
            told["name"], told["message"], told["step"], told["device"], told["action"]
        )  # fmt: skip

    def at(self, step: str) -> "Failure":
        """The same failure, with the step named if none is yet."""
        return self if self.step else replace(self, step=step)

    def sentence(self) -> str:
        """One line for a person: where, what."""
        where = [part for part in (self.step, self.action) if part]
        own = ": ".join((*where, self.name, self.message))
        return "; ".join((own, *(other.sentence() for other in self.others)))

    def told_in(self, frame: "Frame") -> str:
        """`words` for a log, behind the iterations in which this frame is."""
        return ", ".join([*(words(index) for words, index in frame.around), self.words()])

    def words(self) -> str:
        """One line for a person who knows neither paths nor codes.

        `point 10 of 35 (x = 4 mm): libs.measure: its button was not found, 3 tries; no more than 2
        may fail`.
        """
        what = self.message or self.name
        if self.name == "Expression" and what.endswith("...)"):
            what = what.rpartition(" (in ")[0]  # a long expression says no more where it is cut off
        if self.action and not what.startswith(self.action):
            what = f"{self.action}: {what}"
        what += f", {self.tries} tries" if self.tries > 1 else ""
        what += f"; {self.limit}" if self.limit else ""
        step = self.step.rpartition("/")[2]
        named = f"step {step}" if step and not step.isdecimal() else ""
        where = ", ".join(self.where) or named
        own = f"{where}: {what}" if where else what
        return "; ".join(dict.fromkeys((own, *(other.words() for other in self.others))))
