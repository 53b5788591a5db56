"""rosmsg as far as programs import it: texts of definitions."""

import os

from genpy.message import get_message_class, get_service_class

from rosproto.errors import DefinitionError
from rosproto.msg.spec import unfolded
from rosproto.rospy.finder import library

MODE_MSG, MODE_SRV = ".msg", ".srv"


class ROSMsgException(Exception):
    """A type is unknown."""


def _spelled(spec, raw):
    return spec.text if raw else "".join(line + "\n" for line in unfolded(spec, library().message))


def _get_package_paths(pkgname, rospack):
    """The folders of a package; programs use this private function."""
    return [rospack.get_path(pkgname)]


def iterate_packages(rospack, mode):
    """(package, folder of its definitions) of every package that has messages, or services."""
    for package in library().packages():
        folder = os.path.join(library().folder(package) or "", mode.lstrip("."))
        if os.path.isdir(folder):
            yield package, folder


def get_msg_text(type_, raw=False, rospack=None):
    """The fields of a message, those of nested ones indented; `raw`: its file."""
    try:
        return _spelled(library().message(type_), raw)
    except DefinitionError as error:
        raise ROSMsgException(str(error)) from None


def get_srv_text(type_, raw=False, rospack=None):
    """The same of a service."""
    try:
        spec = library().service(type_)
        return "%s---\n%s" % (_spelled(spec.request, raw), _spelled(spec.response, raw))
    except DefinitionError as error:
        raise ROSMsgException(str(error)) from None


def list_types(package, mode=MODE_MSG, rospack=None):
    """Names of a package's messages or services."""
    if mode not in (MODE_MSG, MODE_SRV):
        raise ValueError("Unknown mode for list_types: %s" % mode)
    return sorted(library().messages(package) if mode == MODE_MSG else library().services(package))


def list_msgs(package, rospack=None):
    """Names of a package's messages."""
    return list_types(package)


def list_srvs(package, rospack=None):
    """Names of a package's services."""
    return list_types(package, MODE_SRV)


def rosmsg_md5(mode, type_):
    """md5sum of a message or service."""
    found = (get_message_class if mode == MODE_MSG else get_service_class)(type_)
    if found is None:
        raise OSError("cannot load [%s]" % type_)
    return found._md5sum
