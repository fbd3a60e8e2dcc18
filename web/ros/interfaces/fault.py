"""Why the lab cannot be offered, as a sentence for the user."""


class RosFault(Exception):
    """ROS or its packages are missing, or the lab's `ros` names something that does not exist."""
