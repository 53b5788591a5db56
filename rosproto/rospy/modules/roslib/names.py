"""roslib.names: rosgraph's, under its old name."""

from rosgraph.names import (
    ANYTYPE,
    PRIV_NAME,
    REMAP,
    SEP,
    anonymous_name,
    canonicalize_name,
    get_ros_namespace,
    is_global,
    is_legal_base_name,
    is_legal_name,
    is_private,
    load_mappings,
    make_global_ns,
    namespace,
    ns_join,
    resolve_name,
)

__all__ = [
    "ANYTYPE",
    "PRIV_NAME",
    "REMAP",
    "SEP",
    "anonymous_name",
    "canonicalize_name",
    "get_ros_namespace",
    "is_global",
    "is_legal_base_name",
    "is_legal_name",
    "is_private",
    "load_mappings",
    "make_global_ns",
    "namespace",
    "ns_join",
    "resolve_name",
]
