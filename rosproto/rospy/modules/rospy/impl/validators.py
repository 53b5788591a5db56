"""ParameterInvalid."""


class ParameterInvalid(Exception):
    """An argument is not what it should be."""
