"""From an alarm back to a controller that answers: still locked, but with reports.

After a hard or soft limit a controller answers nothing until it is reset, and a reset in the half
second before it has said `[MSG:Reset to continue]` is swallowed. After the other alarms it boots
by itself. Nothing moves in any of this, and the lock stays: that is for `unlock` or `home`.
"""

from .controller import Controller

SAYS_SO_S = 1.5
BOOTS_S = 1.5
TRIES = 3
NO_RESET = (
    ". It takes no reset since: where an emergency stop is pressed release it, and unlock; "
    "else switch it off and on"
)


async def recover(controller: Controller, tries: int = TRIES) -> None:
    """Wait for what comes after an alarm, reset, and wait for the boot; `alarm` says if none came."""
    await controller.until(lambda: controller.wants_reset or not controller.dead, SAYS_SO_S)
    for _ in range(tries):
        if not controller.dead or controller.lost:
            return
        controller.reset()
        await controller.until(lambda: not controller.dead or bool(controller.lost), BOOTS_S)
    if controller.dead and not controller.lost and NO_RESET not in controller.alarm:
        controller.alarm += NO_RESET


RECOVERED_S = SAYS_SO_S + TRIES * BOOTS_S
"""How long that takes at most."""
