"""dynamic_reconfigure: the client's side."""

import rosservice

from .encoding import decode_config, encode_config


class DynamicReconfigureException(Exception):
    """Base of the others."""


class DynamicReconfigureParameterException(DynamicReconfigureException):
    """A parameter is unknown, or a value does not fit."""


class DynamicReconfigureCallbackException(DynamicReconfigureException):
    """A callback cannot be called."""


def find_reconfigure_services():
    """Names of the nodes that can be reconfigured."""
    suffix = "/set_parameters"
    return sorted(name[: -len(suffix)] for name in rosservice.get_service_list() if name.endswith(suffix))


def get_parameter_names(descr):
    """Names of a description's parameters."""
    return descr.defaults.keys()
