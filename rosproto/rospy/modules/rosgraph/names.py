"""Names, as rosgraph handles them: every name that rospy accepts is accepted."""

import os
import re
import sys

from rosproto import names
from rosproto.names import anonymous_name
from rosproto.names import join as ns_join

from .rosenv import ROS_NAMESPACE

MSG_EXT = ".msg"
SRV_EXT = ".srv"
SEP = "/"
GLOBALNS = "/"
PRIV_NAME = "~"
REMAP = ":="
ANYTYPE = "*"

_LEGAL = re.compile(r"[~/A-Za-z][\w/]*\Z")
_LEGAL_BASE = re.compile(r"[A-Za-z]\w*\Z")
_LEGAL_REMAP = re.compile(r"([~/A-Za-z]|__?)[\w/]*:=.*\Z")


def isstring(s):
    """True for str."""
    return isinstance(s, str)


def get_ros_namespace(env=None, argv=None):
    """`__ns:=` of the command line, else ROS_NAMESPACE, else "/"; with a slash at both ends."""
    for word in sys.argv if argv is None else argv:
        if word.startswith("__ns:="):
            return make_global_ns(word[len("__ns:=") :])
    return make_global_ns((os.environ if env is None else env).get(ROS_NAMESPACE, GLOBALNS))


def make_caller_id(name):
    """A name in the namespace of this process, with a slash at its end."""
    return make_global_ns(ns_join(get_ros_namespace(), name))


def make_global_ns(name):
    """ "/name/" of "name"."""
    if is_private(name):
        raise ValueError("cannot turn [%s] into a global name" % name)
    if not is_global(name):
        name = SEP + name
    return name if name.endswith(SEP) else name + SEP


def is_global(name):
    """True for a name that begins with a slash."""
    return name and name[0] == SEP


def is_private(name):
    """True for a name that begins with a tilde."""
    return name and name[0] == PRIV_NAME


def namespace(name):
    """The namespace of a name, with a slash at its end."""
    if name is None:
        raise ValueError("name")
    if not isstring(name):
        raise TypeError("name")
    return names.namespace(name)


def load_mappings(argv):
    """`name:=other` of a command line; `_parameter:=value` is left out."""
    mappings = {}
    for word in argv:
        if not is_legal_remap(word):
            continue
        parts = [part.strip() for part in word.split(REMAP)]
        if len(parts) != 2:
            sys.stderr.write("ERROR: Invalid remapping argument '%s'\n" % word)
            continue
        source, target = parts
        if source and target and not (len(source) > 1 and source[0] == "_" and source[1] != "_"):
            mappings[source] = target
    return mappings


def is_legal_name(name):
    """A letter, slash or tilde, then letters, digits, underscores, slashes; "" is legal."""
    return name is not None and (name == "" or (bool(_LEGAL.match(name)) and "//" not in name))


def is_legal_base_name(name):
    """The same without namespaces."""
    return name is not None and bool(_LEGAL_BASE.match(name))


def is_legal_remap(arg):
    """True for `name:=value` of any kind."""
    return arg is not None and bool(_LEGAL_REMAP.match(arg))


def canonicalize_name(name):
    """The name without double slashes and without one at the end."""
    return names.canonicalize(name) if name else name


def resolve_name(name, namespace_, remappings=None):
    """The global name that a name means for the node `namespace_`."""
    if not name:
        return namespace(namespace_)
    name = canonicalize_name(name)
    if name[0] == SEP:
        resolved = name
    elif is_private(name):
        resolved = canonicalize_name(namespace_ + SEP + name[1:])
    else:
        resolved = namespace(namespace_) + name
    return remappings.get(resolved, resolved) if remappings else resolved


def script_resolve_name(script_name, name):
    """As `resolve_name`, for a script that is no node."""
    if not name:
        return get_ros_namespace()
    if is_global(name):
        return name
    if is_private(name):
        return ns_join(make_caller_id(script_name), name[1:])
    return get_ros_namespace() + name
