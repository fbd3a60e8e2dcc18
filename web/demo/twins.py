"""The simulated devices with faults to order while they run; loaded by path from the demo's lab."""

from collections.abc import Iterator
from contextlib import contextmanager

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.sim_balance import SimBalance
from labrun.drivers.sim_depth_camera import SimDepthCamera
from labrun.drivers.sim_gantry import SimGantry
from labrun.drivers.sim_libs import SimLibs
from labrun.drivers.sim_pipette import SimPipette
from labrun.drivers.twins.twin import Twin
from labrun.web.demo.orders import take


class Ordered(Twin):
    """Looks, before an action happens, whether it is to fail."""

    @contextmanager
    def failing(self, action: str, goal: GoalContext) -> Iterator[None]:
        known = self.faults.contract.actions[action].errors
        ordered = take(self.place.world, self.place.device, action)
        if ordered is not None and known:
            error = ordered["error"] or next(iter(known))
            happened = "yes" if known[error].happened == "yes" else "no"
            if happened == "no":
                raise ActionFailed(error, f"{action} was ordered to fail (demo)", "no")
            with super().failing(action, goal):
                yield
            raise ActionFailed(error, f"{action} was ordered to fail (demo)", "yes")
        with super().failing(action, goal):
            yield


class Gantry(Ordered, SimGantry):
    """The simulated gantry, with faults to order."""


class Libs(Ordered, SimLibs):
    """The simulated analyser, with faults to order."""


class Balance(Ordered, SimBalance):
    """The simulated balance, with faults to order."""


class Pipette(Ordered, SimPipette):
    """The simulated pipette, with faults to order."""


class DepthCamera(Ordered, SimDepthCamera):
    """The simulated camera, with faults to order."""
