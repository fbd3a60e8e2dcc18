"""A controller's state in terms of the contract's `status`."""

from .controller import Contact, Controller

STATES = {"Run": "moving", "Jog": "moving", "Home": "homing", "Hold": "hold", "Door": "hold"}


def state_of(controller: Controller, doing: str | None) -> str:
    """The contract's `state`; `doing` is the driver's activity, which a report may not show yet."""
    report = controller.report
    if controller.lost or report is None:
        return "offline"
    if doing == "home":
        return "homing"
    if controller.contact is Contact.SILENT:
        return "offline"
    if controller.alarm or controller.dead or report.state == "Alarm":
        return "alarm"
    return STATES.get(report.state) or ("moving" if doing else "idle")


def trouble_of(controller: Controller) -> str:
    """Why it cannot continue, and what to do; empty if it can."""
    if controller.lost:
        return f"{controller.lost}. It reconnects when it is back"
    if controller.alarm:
        return controller.alarm
    if controller.contact is Contact.SILENT:
        return controller.why
    state = controller.report.state if controller.report else ""
    if state == "Alarm":
        return "it is locked until it is homed (or unlocked, without a known position)"
    if state in ("Door", "Sleep", "Check"):
        return f"it is in state {state}; resume or halt it"
    return ""
