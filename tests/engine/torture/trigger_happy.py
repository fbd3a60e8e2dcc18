"""An analyser that keeps no promise: it fires twice for every requested shot."""

from labrun.drivers.simulated.libs import SimLibs


class TriggerHappy(SimLibs):
    def _fire(self, goal):
        super()._fire(goal)
        return super()._fire(goal)
