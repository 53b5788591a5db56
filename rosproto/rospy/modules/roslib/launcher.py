"""load_manifest."""

import os

from rosproto.rospy.finder import stand_ins

from .packages import definitions_folder, find_package, package_around


def load_manifest(package_name, bootstrap_version="0.7"):
    """Check that there is such a package; what is in it is importable anyway.

    Raises:
        rospkg.ResourceNotFound: It is none that is served, on ROS_PACKAGE_PATH, or around the program.
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
