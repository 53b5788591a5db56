"""ActionException."""


class ActionException(Exception):
    """A type is not an action type."""
