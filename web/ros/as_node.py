"""`labrun ros --node`: find ROS and the interfaces, then run as a node until Ctrl-C."""

# rclpy exists only where ROS is installed.
# pyright: reportMissingImports=false

from collections.abc import Callable, Sequence
from typing import Any

from ...engine.lab.lab import LoadedLab
from ...system.signals import until_end
from ...system.tasks import end, first_of, keep, spawn
from .interfaces.fault import RosFault
from .offers.greeting import greeting
from .offers.offer import Offers
from .offers.offered_lab import Folders
from .open_lab import opened


async def run_node(
    lab: LoadedLab,
    package: str,
    folders: Folders,
    ros_args: Sequence[str],
    say: Callable[[str], None],
) -> None:
    """Serve until a signal; raises RosFault naming what is missing, or why the node ended."""
    try:
        import rclpy  # noqa: F401 - whether it is there is asked before any device is started
    except ImportError as fault:
        raise RosFault(
            f"this Python has no ROS 2 ({fault}): source your ROS first, such as "
            "`source /opt/ros/jazzy/setup.bash`; `labrun ros` without --node does not need it"
        ) from fault
    from .node.diagnostics import tell_diagnostics
    from .node.face import node

    over = until_end()
    types: dict[str, Any] = {}

    def check(offers: Offers) -> None:
        types.update(types_of(offers))

    async with (
        opened(lab, package, folders, check) as offered,
        node(offered.offers, offered.goals, types, ros_args) as (made, died),
    ):
        say(f"labrun ros is the node {made.get_fully_qualified_name()}")
        for line in greeting(offered):
            say(line)
        telling = keep(
            "the diagnostics",
            lambda: tell_diagnostics(
                made, offered.devices, lambda name: offered.statuses.get(name, {})
            ),
        )
        ends = [spawn("a signal", over.wait()), spawn("the end of the node", died.wait())]
        try:
            await first_of(ends)
        finally:
            await end(telling, *ends)
        if died.is_set() and not over.is_set():
            raise RosFault(
                "the node of ROS ended by itself; see the lines above. The devices are in their safe "
                "state; start it again"
            )


def types_of(offers: Offers) -> dict[str, Any]:
    """Type -> class, for everything offered; raises RosFault."""
    from .node.types import built

    offered = [*offers.actions.values(), *offers.services.values(), *offers.topics.values()]
    return {one.kind.type: built(one.kind) for one in offered}
