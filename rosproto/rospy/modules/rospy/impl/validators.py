"""ParameterInvalid."""


class ParameterInvalid(Exception):
    """An argument is invalid."""


def non_empty(param_name):
    """A check of an argument of the slave API: not None, not empty."""

    def validator(param, context):
        if not param:
            raise ParameterInvalid("ERROR: parameter [%s] must be specified and non-empty" % param_name)
        return param

    return validator
