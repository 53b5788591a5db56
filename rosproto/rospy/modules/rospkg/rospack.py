"""rospkg.rospack: RosPack."""

import os

from roslib.packages import definitions_folder, find_package, list_packages, package_around

from .common import ResourceNotFound
from .environment import get_ros_paths


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
