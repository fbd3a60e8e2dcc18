"""`labrun ros --node`: look for ROS, look for the interfaces, be a node until Ctrl-C."""

# rclpy is only where ROS is.
# pyright: reportMissingImports=false

from collections.abc import Callable
from typing import Any

from ....engine.lab import LoadedLab
from ..fault import RosFault
from ..greeting import greeting
from ..offer import Offers
from ..signals import until_signal
from ..site import Folders, opened


async def run_node(
    lab: LoadedLab, package: str, folders: Folders, say: Callable[[str], None]
) -> None:
    """Serve until a signal; raises RosFault with what is missing."""
    try:
        import rclpy  # noqa: F401 - whether it is there is asked before any device is started
    except ImportError as fault:
        raise RosFault(
            f"there is no ROS 2 in this Python ({fault}): source your ROS first, such as "
            "`source /opt/ros/jazzy/setup.bash`; `labrun ros` without --node needs none"
        ) from fault
    from .face import node

    over = until_signal()
    types: dict[str, Any] = {}

    def check(offers: Offers) -> None:
        types.update(types_of(offers))

    async with (
        opened(lab, package, folders, check) as site,
        node(site.offers, site.goals, types) as made,
    ):
        say(f"labrun ros is the node /{made.get_name()}")
        for line in greeting(site):
            say(line)
        await over.wait()


def types_of(offers: Offers) -> dict[str, Any]:
    """Type -> class, for everything on offer; raises RosFault."""
    from .types import built

    offered = [*offers.actions.values(), *offers.services.values(), *offers.topics.values()]
    return {one.kind.type: built(one.kind) for one in offered}
