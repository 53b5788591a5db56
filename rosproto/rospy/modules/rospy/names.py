"""rospy.names: this node's name, name resolution and command-line remappings."""

import sys
import warnings

import rosgraph.names
from rosgraph.names import (
    ANYTYPE,
    GLOBALNS,
    PRIV_NAME,
    REMAP,
    SEP,
    canonicalize_name,
    get_ros_namespace,
    is_global,
    is_legal_name,
    is_private,
    isstring,
    load_mappings,
    namespace,
    ns_join,
)

from .exceptions import ROSException, ROSInitException
from .impl.validators import ParameterInvalid, validator_of

TOPIC_ANYTYPE = ANYTYPE
SERVICE_ANYTYPE = ANYTYPE

_TEXT = (lambda value: isstring(value) and value, "must be a non-empty string")
_LEGAL = (lambda value: not set(": ") & set(value), "contains illegal chars")
_NOT_ROOT = (lambda value: value != GLOBALNS, "cannot be the global namespace")
global_name = validator_of(_TEXT, (is_global, "must be a globally referenced name"))
valid_name = validator_of(_TEXT, _LEGAL, meant=rosgraph.names.resolve_name)
is_topic = validator_of(_NOT_ROOT, _TEXT, _LEGAL, meant=rosgraph.names.resolve_name)  # rospy.core's

_mappings = load_mappings(sys.argv)
_resolved_mappings = {}
_caller_namespace = get_ros_namespace()
_caller_id = _caller_namespace + "unnamed"


def reload_mappings(argv):
    """Replace the remappings by those of `argv`."""
    global _mappings
    _mappings = load_mappings(argv)


def initialize_mappings(node_name):
    """Resolve the remappings relative to a node."""
    global _resolved_mappings
    _resolved_mappings = {
        name if name.startswith("__") else rosgraph.names.resolve_name(name, node_name): (
            other if name.startswith("__") else rosgraph.names.resolve_name(other, node_name)
        )
        for name, other in _mappings.items()
    }


def get_mappings():
    """The remappings as written."""
    return _mappings


def get_resolved_mappings():
    """The remappings, both sides resolved."""
    return _resolved_mappings


def get_name():
    """Global name of this node; "/unnamed" before `init_node`."""
    return _caller_id


get_caller_id = get_name


def get_namespace():
    """Namespace of this node, with a trailing slash."""
    return _caller_namespace


def set_caller_id(caller_id):
    global _caller_id, _caller_namespace
    _caller_id = caller_id
    _caller_namespace = namespace(caller_id)


_set_caller_id = set_caller_id  # rospy's name for it


def resolve_name(name, caller_id=None):
    """Resolve and remap a name to a global name."""
    name, caller_id = canonicalize_name(str(name or "")), caller_id or get_name()
    if is_private(name):
        resolved = ns_join(caller_id, name[1:])
        return _resolved_mappings.get(resolved, resolved)
    return rosgraph.names.resolve_name(name, caller_id, _resolved_mappings)


def resolve_name_without_node_name(name):
    """As `resolve_name`, for a topic created before the node has a name."""
    if is_private(name):
        raise ValueError("~name topics cannot be created before init_node() has been called")
    node = ns_join(get_namespace(), "node")
    resolved = rosgraph.names.resolve_name(name, node)
    for one, other in _mappings.items():
        if rosgraph.names.resolve_name(one, node) == resolved:
            if is_private(other):
                raise ROSInitException(
                    "due to the way this node is written, %s cannot be remapped to a ~name. \n"
                    "The declaration of topics/services must be moved after the call to init_node()" % name
                )
            return rosgraph.names.resolve_name(other, node)
    return resolved


def remap_name(name, caller_id=None, resolved=True):
    """Remap and resolve a name; a name without a remapping is returned unchanged."""
    if name in _mappings:
        return rosgraph.names.resolve_name(_mappings[name], caller_id or get_caller_id())
    return name


def scoped_name(caller_id, name):
    """The name relative to a node's namespace."""
    if not is_global(caller_id):
        raise ROSException("caller_id must be global")
    return canonicalize_name(name)[len(namespace(caller_id)) :]


def warn_if_illegal(name, stacklevel):
    """Warn of a name that is not legal; `stacklevel` as the caller would give it to warnings.warn."""
    if not is_legal_name(name):
        warnings.warn(
            "'%s' is not a legal ROS graph resource name. This may cause problems with other ROS tools"
            % name,
            stacklevel=stacklevel + 1,
        )
