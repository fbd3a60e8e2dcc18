"""A rosbridge v2 endpoint: WebSocket in, JSON or CBOR out, and no ROS behind it.

RobotWebTools, *rosbridge v2 Protocol Specification* (rosbridge_suite, ROSBRIDGE_PROTOCOL.md).
"""
