"""The lab as a node of a real ROS 2; rclpy is imported here alone."""
