"""roslib.packages: where packages are. There is no ROS installation, so ROS_PACKAGE_PATH decides."""

import os


class InvalidROSPkgException(Exception):
    """There is no such package."""


def get_pkg_dir(package, required=True, ros_root=None, ros_package_path=None):
    """Folder of a package of ROS_PACKAGE_PATH: one with that name and a package.xml in it."""
    found = _find(package, ros_package_path or os.environ.get("ROS_PACKAGE_PATH", ""))
    if found is None and required:
        raise InvalidROSPkgException("Cannot locate installation of package %s" % package)
    return found


def _find(package, path):
    for root in filter(None, path.split(os.pathsep)):
        for folder, inner, files in os.walk(root):
            if "package.xml" in files:
                inner[:] = []
                if os.path.basename(folder) == package:
                    return folder
    return None
