"""Any ROS 2 action server as a device, through a rosbridge or as a node if ROS is installed.

Never imports ROS unless a lab asks for it.
"""
