"""roslib.exceptions: the base of roslib's errors."""


class ROSLibException(Exception):
    """Base of roslib's errors."""
