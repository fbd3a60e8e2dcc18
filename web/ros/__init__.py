"""The lab in ROS: through a rosbridge endpoint without ROS installed, or as a node.

Has no separate action path: goals are handled like all other goals.
"""
