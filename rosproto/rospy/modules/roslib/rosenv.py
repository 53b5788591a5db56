"""roslib.rosenv: the environment, under its old names."""

import os

from rosgraph.rosenv import ROS_HOSTNAME, ROS_IP, ROS_MASTER_URI, ROS_NAMESPACE
from rosgraph.rosenv import get_master_uri as _master_uri
from rospkg.environment import (
    ROS_HOME,
    ROS_LOG_DIR,
    ROS_PACKAGE_PATH,
    ROS_ROOT,
    get_log_dir,
    get_ros_home,
    get_test_results_dir,
)


class ROSEnvException(Exception):
    """A variable is not set, or is wrong."""


def _variable(name, required, env):
    value = (os.environ if env is None else env).get(name)
    if value is None and required:
        raise ROSEnvException("%s has not been configured" % name)
    return value


def get_ros_root(required=True, env=None):
    """ROS_ROOT."""
    return _variable(ROS_ROOT, required, env)


def get_ros_package_path(required=False, env=None):
    """ROS_PACKAGE_PATH."""
    return _variable(ROS_PACKAGE_PATH, required, env)


def get_master_uri(required=True, env=None, argv=None):
    """`__master:=` of the command line, else ROS_MASTER_URI."""
    try:
        given = _master_uri({}, argv)
    except ValueError as error:
        raise ROSEnvException(str(error)) from None
    return given if given != _master_uri({}, []) else _variable(ROS_MASTER_URI, required, env)
