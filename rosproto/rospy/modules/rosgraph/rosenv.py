"""The master's URI in the environment and on the command line."""

import os
import sys

ROS_MASTER_URI = "ROS_MASTER_URI"
ROS_IP = "ROS_IP"
ROS_IPV6 = "ROS_IPV6"
ROS_HOSTNAME = "ROS_HOSTNAME"
ROS_NAMESPACE = "ROS_NAMESPACE"
DEFAULT_MASTER_PORT = 11311
DEFAULT_MASTER_URI = "http://localhost:%s/" % DEFAULT_MASTER_PORT


def get_master_uri(env=None, argv=None):
    """`__master:=` of the command line, else ROS_MASTER_URI, else this computer."""
    for word in sys.argv if argv is None else argv:
        if word.startswith("__master:="):
            uri = word[len("__master:=") :]
            if not uri or ":=" in uri:
                raise ValueError("__master remapping argument '%s' improperly specified" % word)
            return uri
    return (os.environ if env is None else env).get(ROS_MASTER_URI, DEFAULT_MASTER_URI)
