"""What one shot at the simulated core brings to light."""

from typing import Any

import numpy as np

from . import instrument
from .core import Core
from .csv_text import CsvText
from .plasma import Plasma, State, spark


class ShotMaker:
    """Spectra of shots at one core; the same shot has the same spectrum, noise and all."""

    def __init__(self, core: int, seed: int) -> None:
        self.core = Core(core)
        self.seed = seed
        self.plasma = Plasma()
        self.text = CsvText(self.plasma.axis)

    def surface(self, x: float, y: float) -> tuple[str | None, float]:
        """Mineral and height (mm) at a place; None beside the core."""
        if not self.core.holds(x, y):
            return None, 0.0
        return self.core.mineral_at(x, y), self.core.height_at(x, y)

    def counts(self, shot: dict[str, Any]) -> np.ndarray:
        """Counts of all channels for a line of the analyser's log."""
        random = np.random.default_rng([self.seed, shot["n"]])
        state = spark(random)
        if not shot["focus"]:
            return instrument.detect(np.zeros(instrument.CHANNELS), random)
        fainter = State(state.temperature_ev, state.electrons_per_cm3, state.amount * shot["focus"])
        atoms = self.core.composition_in_crater(shot["x"], shot["y"])
        return instrument.detect(self.plasma.light(atoms, fainter), random)

    def csv(self, shot: dict[str, Any]) -> bytes:
        """The spectrum of a shot as the analyser exports it."""
        return self.text.write(self.counts(shot))
