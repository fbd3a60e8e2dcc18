"""The simulated devices with injected faults; loaded by path from the demo's lab."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.simulated.balance import SimBalance
from labrun.drivers.simulated.colour_camera import SimColourCamera
from labrun.drivers.simulated.depth_camera import SimDepthCamera
from labrun.drivers.simulated.dispenser import SimDispenser
from labrun.drivers.simulated.furnace import SimFurnace
from labrun.drivers.simulated.gantry import SimGantry
from labrun.drivers.simulated.leak_sensor import SimLeakSensor
from labrun.drivers.simulated.libs import SimLibs
from labrun.drivers.simulated.microscope import SimMicroscope
from labrun.drivers.simulated.ph_probe import SimPhProbe
from labrun.drivers.simulated.pipette import SimPipette
from labrun.drivers.simulated.plate_reader import SimPlateReader
from labrun.drivers.simulated.pump import SimPump
from labrun.drivers.simulated.twins.twin import Twin
from labrun.web.demo.orders import lasts, take

SLOWER = 20
LOOKS_S = 0.2
HANGS_LOOKS = 300
"""A stop that is not to be confirmed: after a minute the safe state is reached all the same."""


class Ordered(Twin):
    """Checks before each action whether it is to fail, and with each status what lasts."""

    def lasts(self, kind: str) -> bool:
        """Whether such a fault was requested and not cleared since."""
        return lasts(self.place.world, self.place.device, kind)

    async def status(self) -> dict[str, Any]:
        self.clock.slower = SLOWER if self.lasts("slow") else 1
        return await super().status()

    @contextmanager
    def failing(self, action: str, goal: GoalContext) -> Iterator[None]:
        known = self.faults.contract.actions[action].errors
        ordered = take(self.place.world, self.place.device, action)
        if ordered is not None and known:
            error = ordered["error"] or next(iter(known))
            happened = "yes" if known[error].happened == "yes" else "no"
            if happened == "no":
                raise ActionFailed(error, f"{action}: injected fault (demo)", "no")
            with super().failing(action, goal):
                yield
            raise ActionFailed(error, f"{action}: injected fault (demo)", "yes")
        with super().failing(action, goal):
            yield


class Stoppable(Ordered):
    """One with a safe state, which may be ordered not to be reached."""

    async def safe(self) -> None:
        for _ in range(HANGS_LOOKS):
            if not self.lasts("stop"):
                break
            await asyncio.sleep(LOOKS_S)
        await super().safe()


class Gantry(Stoppable, SimGantry):
    """The simulated gantry, with injected faults."""


class Libs(Stoppable, SimLibs):
    """The simulated analyser, with injected faults, and an enclosure that opens."""

    def interlock(self) -> str:
        return "open" if self.lasts("interlock") else super().interlock()


class Balance(Ordered, SimBalance):
    """The simulated balance, with injected faults."""


class Pipette(Stoppable, SimPipette):
    """The simulated pipette, with injected faults."""


class Dispenser(Stoppable, SimDispenser):
    """The simulated dispenser, with injected faults."""


class ColourCamera(Ordered, SimColourCamera):
    """The simulated colour camera, with injected faults."""


class DepthCamera(Ordered, SimDepthCamera):
    """The simulated camera, with injected faults."""


class Pump(Stoppable, SimPump):
    """The simulated burette, with injected faults."""


class PhProbe(Ordered, SimPhProbe):
    """The simulated electrode, with injected faults."""


class Furnace(Stoppable, SimFurnace):
    """The simulated furnace, with injected faults."""


class LeakSensor(Ordered, SimLeakSensor):
    """The simulated leak sensor, with injected faults."""


class Microscope(Ordered, SimMicroscope):
    """The simulated microscope, with injected faults."""


class PlateReader(Ordered, SimPlateReader):
    """The simulated plate reader, with injected faults."""
