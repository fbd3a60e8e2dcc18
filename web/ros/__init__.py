"""The lab as ROS sees it: by a rosbridge endpoint with no ROS installed, and by a node where it is."""
