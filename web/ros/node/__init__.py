"""The lab as a node of a real ROS 2; rclpy is imported only here.

Never blocks ROS's thread for our event loop.
"""
