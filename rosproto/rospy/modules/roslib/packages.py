"""roslib.packages: the folders of packages, by ROS_PACKAGE_PATH instead of a ROS installation."""

import os
import sys

from rosproto.rospy.finder import library


class ROSPkgException(Exception):
    """A package cannot be used."""


class InvalidROSPkgException(ROSPkgException):
    """There is no such package."""


def get_pkg_dir(package, required=True, ros_root=None, ros_package_path=None):
    """Folder of a package of ROS_PACKAGE_PATH (it holds a package.xml), or of one's definitions."""
    found = find_package(
        package, ros_package_path or os.environ.get("ROS_PACKAGE_PATH", "")
    ) or definitions_folder(package)
    if found is None and required:
        raise InvalidROSPkgException("Cannot locate installation of package %s" % package)
    return found


def get_pkg_subdir(package, subdir, required=True, env=None):
    """A folder inside a package, made when it is `required` and not there."""
    path = (os.environ if env is None else env).get("ROS_PACKAGE_PATH", "")
    found = os.path.join(get_pkg_dir(package, ros_package_path=path), subdir)
    if required:
        os.makedirs(found, exist_ok=True)
    return found if os.path.isdir(found) else None


def resource_file(package, subdir, resource_name):
    """Return the path of a file in a package's folder; it need not exist."""
    return os.path.join(get_pkg_subdir(package, subdir, False) or "", resource_name)


def find_resource(pkg, resource_name, filter_fn=None, rospack=None):
    """Every file of that name in a package, hidden folders left out."""
    found = []
    for folder, inner, files in os.walk(get_pkg_dir(pkg)):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        if resource_name in files:
            found.append(os.path.join(folder, resource_name))
    return [path for path in found if filter_fn is None or filter_fn(path)]


def find_node(pkg, node_type, rospack=None):
    """The programs of that name in a package."""
    return find_resource(pkg, node_type, lambda path: os.access(path, os.X_OK), rospack)


def list_packages(path):
    """(name, folder) of every package below the folders of a path."""
    for root in filter(None, path.split(os.pathsep)):
        for folder, inner, files in os.walk(root):
            if "package.xml" in files:
                inner[:] = []
                yield os.path.basename(folder), folder


def find_package(package, path):
    return next((folder for name, folder in list_packages(path) if name == package), None)


def package_around(name):
    """The folder of a package in which the program lies, None when it is in none of that name."""
    folder = os.path.dirname(os.path.abspath(sys.argv[0]))
    while True:
        if os.path.basename(folder) == name and os.path.isfile(os.path.join(folder, "package.xml")):
            return folder
        if os.path.dirname(folder) == folder:
            return None
        folder = os.path.dirname(folder)


def definitions_folder(package):
    """The folder of a message package's definitions, None when there is none."""
    return library().folder(package)
