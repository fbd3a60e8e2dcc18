"""What keeps the lab from being offered, as a sentence for whoever started it."""


class RosFault(Exception):
    """ROS is not there, its packages are not, or the lab's `ros` names what there is not."""
