"""rosgraph: names, the environment, and the master by its API."""

import sys

from . import names, network, rosenv
from .masterapi import Master, MasterError, MasterException, MasterFailure
from .masterapi import is_online as is_master_online
from .rosenv import (
    ROS_HOSTNAME,
    ROS_IP,
    ROS_IPV6,
    ROS_MASTER_URI,
    ROS_NAMESPACE,
    get_master_uri,
)

__all__ = [
    "ROS_HOSTNAME",
    "ROS_IP",
    "ROS_IPV6",
    "ROS_MASTER_URI",
    "ROS_NAMESPACE",
    "Master",
    "MasterError",
    "MasterException",
    "MasterFailure",
    "get_master_uri",
    "is_master_online",
    "myargv",
    "names",
    "network",
    "rosenv",
]


def myargv(argv=None):
    """sys.argv without the arguments meant for ROS."""
    return [word for word in (sys.argv if argv is None else argv) if names.REMAP not in word]
