"""roslib.resources: the files of a package's folder."""

import os

from .packages import get_pkg_dir


def list_package_resources(package, include_depends, subdir, rfilter=os.path.isfile):
    """Names of the files in a folder of a package; dependencies are not looked into."""
    return list_package_resources_by_dir(get_pkg_dir(package), include_depends, subdir, rfilter)


def list_package_resources_by_dir(package_dir, include_depends, subdir, rfilter=os.path.isfile):
    """The same for the folder of a package."""
    package, folder = os.path.basename(package_dir), os.path.join(package_dir, subdir)
    found = os.listdir(folder) if os.path.isdir(folder) else []
    return ["%s/%s" % (package, name) for name in found if rfilter(os.path.join(folder, name))]
