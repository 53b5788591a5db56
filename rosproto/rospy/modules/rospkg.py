"""rospkg as far as programs use it: the folder of a package, by ROS_PACKAGE_PATH or around the program."""

import os
import sys

__all__ = ["ResourceNotFound", "RosPack", "get_log_dir", "get_ros_home"]


class ResourceNotFound(Exception):
    """There is no such package."""


class RosPack:
    """Finds packages: folders with a package.xml, below ROS_PACKAGE_PATH and around the program."""

    def __init__(self, ros_paths=None):
        self._paths = ros_paths

    def get_path(self, name):
        """The folder of a package.

        Raises:
            ResourceNotFound: There is none of that name.
        """
        from roslib.packages import _find

        paths = self._paths or os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        found = _find(name, os.pathsep.join(paths)) or self._around(name)
        if found is None:
            raise ResourceNotFound(name)
        return found

    @staticmethod
    def _around(name):
        folder = os.path.dirname(os.path.abspath(sys.argv[0]))
        while True:
            if os.path.basename(folder) == name and os.path.isfile(os.path.join(folder, "package.xml")):
                return folder
            if os.path.dirname(folder) == folder:
                return None
            folder = os.path.dirname(folder)


def get_ros_home(env=None):
    """ROS_HOME, else ~/.ros."""
    return (os.environ if env is None else env).get("ROS_HOME") or os.path.join(
        os.path.expanduser("~"), ".ros"
    )


def get_log_dir(env=None):
    """ROS_LOG_DIR, else log in the ROS home."""
    return (os.environ if env is None else env).get("ROS_LOG_DIR") or os.path.join(get_ros_home(env), "log")
