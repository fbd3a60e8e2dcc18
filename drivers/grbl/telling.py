"""A controller's state in the words of the contract's `status`."""

from .controller import Controller

STATES = {"Run": "moving", "Jog": "moving", "Home": "homing", "Hold": "hold", "Door": "hold"}


def state_of(controller: Controller, doing: str | None) -> str:
    """The contract's `state`; `doing` is what the driver is about, which a report may not show yet."""
    report = controller.report
    if controller.lost or report is None:
        return "offline"
    if doing == "home":
        return "homing"
    if controller.mute and not controller.dead:
        return "offline"
    if controller.alarm or controller.dead or report.state == "Alarm":
        return "alarm"
    return STATES.get(report.state) or ("moving" if doing else "idle")


def trouble_of(controller: Controller) -> str:
    """Why it cannot go on, and what now; empty where it can."""
    if controller.lost:
        return f"{controller.lost}. It is taken up again when it is back"
    if controller.alarm:
        return controller.alarm
    if controller.mute:
        return controller.mute
    state = controller.report.state if controller.report else ""
    if state == "Alarm":
        return "it is locked until it is homed (or unlocked, without a known place)"
    if state in ("Door", "Sleep", "Check"):
        return f"it is in the state {state}; resume it, or halt it"
    return ""
