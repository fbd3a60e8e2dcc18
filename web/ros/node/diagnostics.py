"""`/diagnostics`: each device once a second, as rqt_robot_monitor and Foxglove show it."""

# rclpy and diagnostic_msgs exist only where ROS is installed.
# pyright: reportMissingImports=false

import asyncio
import logging
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node

from ..offers.device import Device
from ..offers.offer import Values

TELL_S = 1.0
LOG = logging.getLogger(__name__)
FAULTS = ("alarm", "offline", "error", "fault")
"""States of a device that need somebody."""


async def tell_diagnostics(
    node: Node, devices: Mapping[str, Device], status: Callable[[str], Values]
) -> None:
    """Tell, until cancelled; ends at once where diagnostic_msgs is not installed."""
    try:
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    except ImportError:
        LOG.warning("diagnostic_msgs is not installed, so there is no /diagnostics")
        return
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    levels = {True: DiagnosticStatus.OK, False: DiagnosticStatus.ERROR}
    while True:
        told: Any = DiagnosticArray()
        told.header.stamp = node.get_clock().now().to_msg()
        for name, device in devices.items():
            good, words = condition(device.online, device.reason, status(name))
            one = DiagnosticStatus(
                name=f"labrun: {name}", message=words, level=levels[good],
                hardware_id=device.contract.type,
            )  # fmt: skip
            one.values = [KeyValue(key=k, value=str(v)) for k, v in status(name).items()]
            told.status.append(one)
        publisher.publish(told)
        await asyncio.sleep(TELL_S)


def condition(online: bool, reason: str, status: Values) -> tuple[bool, str]:
    """Whether a device is well, and in words how it is."""
    if not online:
        return False, reason
    state = str(status.get("state", "online"))
    if state.lower() in FAULTS:
        return False, str(status.get("alarm") or state)
    return True, state
