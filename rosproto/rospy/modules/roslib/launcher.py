"""load_manifest."""

import os

from rosproto.rospy.finder import stand_ins

from .packages import definitions_folder, find_package, package_around


def load_manifest(package_name, bootstrap_version="0.7"):
    """Check that the package exists. Its modules are importable without this.

    Raises:
        rospkg.ResourceNotFound: It is not served, on ROS_PACKAGE_PATH, or around the program.
    """
    paths = os.environ.get("ROS_PACKAGE_PATH", "")
    found = (
        package_name in stand_ins()
        or definitions_folder(package_name)
        or find_package(package_name, paths)
        or package_around(package_name)
    )
    if not found:
        import rospkg

        raise rospkg.ResourceNotFound(
            package_name, ros_paths=[path for path in paths.split(os.pathsep) if path]
        )
