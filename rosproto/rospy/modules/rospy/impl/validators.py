"""Validators: functions that take a value and the caller's name, and return the value or what it means."""


class ParameterInvalid(Exception):
    """An argument is invalid."""


def validator_of(*rules, meant=None):
    """Return a function that makes a validator; rules are (true for a valid value, what others are told)."""

    def of_parameter(param_name, resolve=True):
        def validator(value, caller_id):
            for holds, fault in rules:
                if not holds(value):
                    raise ParameterInvalid("ERROR: parameter [%s] %s" % (param_name, fault))
            return meant(value, caller_id) if meant and resolve else value

        return validator

    return of_parameter


non_empty = validator_of((bool, "must be specified and non-empty"))
