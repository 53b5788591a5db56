"""ParameterInvalid."""


class ParameterInvalid(Exception):
    """An argument is invalid."""


def non_empty(param_name):
    """Return a validator of a slave API argument that must not be None or empty."""

    def validator(param, context):
        if not param:
            raise ParameterInvalid("ERROR: parameter [%s] must be specified and non-empty" % param_name)
        return param

    return validator
