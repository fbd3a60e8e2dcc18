"""Any ROS 2 action server as a device: reached through a rosbridge, or as a node where ROS is."""
