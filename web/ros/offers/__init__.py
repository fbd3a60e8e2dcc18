"""What the lab offers to ROS, by endpoint or node: actions, services, topics, goals.

Does not know which of the two it is.
"""
