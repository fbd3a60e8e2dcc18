"""The error for input that is not a readable spectrum."""


class Unreadable(ValueError):
    """The input is not a spectrum; the message says where and why."""
