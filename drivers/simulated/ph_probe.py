"""A simulated pH electrode in a flask with an acid, into which a simulated pump doses a base.

Configuration: `pump` (the device that doses, by its name in the lab), `acid_ml` (the sample's volume),
`acid_m` and `titrant_m` (mol/L), `pka` (of the acid), `water_ml` (added so that the electrode is
immersed).

The pH follows from the balance of charges of a weak acid with a strong base. The electrode does what the
glass does (Galster, pH Measurement, 1991): it follows within seconds where the solution is buffered, and
several times slower in the jump, where little is there to carry it; its slope is a percent or two below
Nernst's; it drifts by hundredths an hour. So a reading taken at once after a dose is wrong where it
matters most, and titrators wait until the signal stays within a band for some seconds (Hanna HI 902:
signal stability).
"""

import math
from random import Random
from typing import Any, ClassVar

from ..driver import GoalContext, Place
from .twins.settling import settled
from .twins.twin import Twin

KW = 1e-14
SLOPE, NOISE, DRIFT_PER_H = 0.985, 0.003, 0.02
LAG_S, SLOW_LAG_S, JUMP_M = 1.5, 6.0, 2e-4  # slow where the buffer capacity is below JUMP_M
TICK_S, STILL, WITHIN = 0.5, 8, 0.02


class SimPhProbe(Twin):
    """Implements ph_probe@1."""

    contract: ClassVar[str] = "ph_probe@1"
    options: ClassVar[tuple[str, ...]] = (
        "pump", "acid_ml", "acid_m", "titrant_m", "pka", "water_ml",
    )  # fmt: skip

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.shown = 7.0
        self.stable = False

    async def open(self) -> None:
        await super().open()
        self.shown = self._electrode(self.true_ph())

    async def status(self) -> dict[str, Any]:
        return {"ph": round(self.shown, 3), "stable": self.stable}

    async def read(self, goal: GoalContext, *, patience: float = 60.0) -> dict[str, Any]:
        random = Random(f"{self.seed}/{goal.id}")
        with self.failing("read", goal):
            ph, self.stable = await settled(
                self.clock, goal, lambda: self._reading(random), patience_s=patience,
                tick_s=TICK_S, still=STILL, within=WITHIN, words=lambda ph: f"pH {ph:.2f}",
            )  # fmt: skip
            self.truth.append("read", goal=goal.id, ph=self.true_ph(), shown=ph)
        return {"ph": round(ph, 3), "stable": self.stable}

    def true_ph(self) -> float:
        """The pH of what is in the flask now."""
        low, high = 0.0, 14.0
        for _ in range(50):
            ph = (low + high) / 2
            low, high = (ph, high) if self._charge(ph) > 0 else (low, ph)
        return low

    def _charge(self, ph: float) -> float:
        """Positive less negative charges at this pH, mol/L: it falls as the pH rises."""
        base, acid = self._contents_m()
        h, ka = 10.0**-ph, 10.0 ** -float(self.config.get("pka", 4.756))
        return h + base - KW / h - acid * ka / (ka + h)

    def _contents_m(self) -> tuple[float, float]:
        """Sodium and total acid in the flask, mol/L."""
        dosed = (self.world.look(self.config.get("pump", "pump")) or {"dosed_ml": 0.0})["dosed_ml"]
        acid_ml = float(self.config.get("acid_ml", 20))
        whole_ml = acid_ml + float(self.config.get("water_ml", 30)) + dosed
        base = float(self.config.get("titrant_m", 0.1)) * dosed / whole_ml
        return base, float(self.config.get("acid_m", 0.08)) * acid_ml / whole_ml

    def _reading(self, random: Random) -> float:
        ph = self.true_ph()
        capacity = (self._charge(ph - 0.05) - self._charge(ph + 0.05)) / 0.1  # mol/L a pH
        lag_s = LAG_S + SLOW_LAG_S / (1 + capacity / JUMP_M)
        self.shown += (self._electrode(ph) - self.shown) * (1 - math.exp(-TICK_S / lag_s))
        return self.shown + random.gauss(0, NOISE)

    def _electrode(self, ph: float) -> float:
        return 7 + SLOPE * (ph - 7) + DRIFT_PER_H * self.clock.elapsed_s / 3600
