"""ActionException."""


class ActionException(Exception):
    """A type is no action."""
