"""A rosbridge v2 endpoint: WebSocket in, JSON or CBOR out.

RobotWebTools, *rosbridge v2 Protocol Specification* (rosbridge_suite, ROSBRIDGE_PROTOCOL.md).

Never needs ROS.
"""
