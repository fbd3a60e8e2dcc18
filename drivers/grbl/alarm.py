"""From an alarm back to a controller that responds: still locked, but reporting.

After a hard or soft limit a controller does not respond until it is reset, and a reset in the half
second before it sends `[MSG:Reset to continue]` is ignored. After the other alarms it boots by
itself. Nothing moves in any of this, and the lock stays: `unlock` or `home` releases it.
"""

from .controller import Contact, Controller

SAYS_SO_S = 1.5
BOOTS_S = 1.5
TRIES = 3
NO_RESET = (
    ". It has not accepted a reset since: if an emergency stop is pressed, release it and unlock; "
    "otherwise switch it off and on"
)


async def recover(controller: Controller, tries: int) -> None:
    """Wait out the alarm's messages, reset, and wait for the boot; `alarm` says if none came."""
    await controller.until(lambda: controller.contact is not Contact.ALARMED, SAYS_SO_S)
    for _ in range(tries):
        if not controller.dead:
            return
        controller.reset()
        await controller.until(lambda: not controller.dead, BOOTS_S)
    if controller.dead and NO_RESET not in controller.alarm:
        controller.alarm += NO_RESET


RECOVERED_S = SAYS_SO_S + TRIES * BOOTS_S
"""How long that takes at most."""
