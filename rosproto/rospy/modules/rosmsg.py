"""rosmsg as far as programs import it: texts of definitions."""

from rosproto.errors import DefinitionError
from rosproto.rospy.finder import library


class ROSMsgException(Exception):
    """A type is unknown."""


def _spelled(spec, raw):
    return spec.text if raw else "".join(line + "\n" for line in _lines(spec, ""))


def _lines(spec, indent):
    for constant in spec.constants:
        yield "%s%s %s=%s" % (indent, constant.type, constant.name, constant.value)
    for field in spec.fields:
        yield "%s%s %s" % (indent, field.type, field.name)
        base = str(field.type).partition("[")[0]
        if "/" in base:
            yield from _lines(library().message(base), indent + "  ")


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
