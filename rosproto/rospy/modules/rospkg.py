"""rospkg as far as programs use it: the folder of a package, by ROS_PACKAGE_PATH or around the program."""

import os

from roslib.packages import definitions_folder, find_package, list_packages, package_around


class ResourceNotFound(Exception):
    """There is no such package.

    Attributes:
        ros_paths: The searched folders.
    """

    def __init__(self, msg, ros_paths=None):
        super().__init__(msg)
        self.ros_paths = ros_paths

    def __str__(self):
        looked = ["\nROS path [%d]=%s" % pair for pair in enumerate(self.ros_paths or ())]
        return self.args[0] + "".join(looked)


def get_ros_paths(env=None):
    """The folders of ROS_PACKAGE_PATH."""
    path = (os.environ if env is None else env).get("ROS_PACKAGE_PATH", "")
    return [folder for folder in path.split(os.pathsep) if folder]


class RosPack:
    """Finds packages: folders with a package.xml, below ROS_PACKAGE_PATH and around the program."""

    def __init__(self, ros_paths=None):
        self.ros_paths = ros_paths or get_ros_paths()

    @classmethod
    def get_instance(cls, ros_paths=None):
        """Return an instance that searches these folders."""
        return cls(ros_paths)

    def get_ros_paths(self):
        """Return the searched folders."""
        return list(self.ros_paths)

    def list(self):
        """Names of all packages."""
        return [name for name, _ in list_packages(os.pathsep.join(self.ros_paths))]

    def get_path(self, name):
        """The folder of a package; of a message package that is served, that of its definitions.

        Raises:
            ResourceNotFound: There is none of that name.
        """
        found = (
            find_package(name, os.pathsep.join(self.ros_paths))
            or package_around(name)
            or definitions_folder(name)
        )
        if found is None:
            raise ResourceNotFound(name, self.ros_paths)
        return found


def get_ros_home(env=None):
    """ROS_HOME, else ~/.ros."""
    return (os.environ if env is None else env).get("ROS_HOME") or os.path.join(
        os.path.expanduser("~"), ".ros"
    )


def get_log_dir(env=None):
    """ROS_LOG_DIR, else log in the ROS home."""
    return (os.environ if env is None else env).get("ROS_LOG_DIR") or os.path.join(get_ros_home(env), "log")
