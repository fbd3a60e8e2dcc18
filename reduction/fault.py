"""What is wrong with something that was given as a spectrum."""


class Unreadable(ValueError):
    """What was given as a spectrum is not one; the message says where and why."""
