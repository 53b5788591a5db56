"""rosmsg as far as programs import it: texts of definitions."""

from rosproto.errors import DefinitionError
from rosproto.msg.spec import unfolded
from rosproto.rospy.finder import library


class ROSMsgException(Exception):
    """A type is unknown."""


def _spelled(spec, raw):
    return spec.text if raw else "".join(line + "\n" for line in unfolded(spec, library().message))


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


def list_msgs(package, rospack=None):
    """Names of a package's messages."""
    return sorted(library().messages(package))


def list_srvs(package, rospack=None):
    """Names of a package's services."""
    return sorted(library().services(package))
