"""rosnode as far as programs import it: names of nodes, ping, kill."""

import sys
import time

import rosgraph

__all__ = [
    "ROSNodeException",
    "ROSNodeIOException",
    "get_api_uri",
    "get_node_names",
    "kill_nodes",
    "rosnode_ping",
]


class ROSNodeException(Exception):
    """A node cannot be used."""


class ROSNodeIOException(ROSNodeException):
    """The master cannot be reached."""


def get_node_names(namespace=None):
    """Sorted names of all nodes, or of those below a namespace."""
    try:
        state = rosgraph.Master("/rosnode").getSystemState()
    except OSError:
        raise ROSNodeIOException("Unable to communicate with master!") from None
    found = {node for table in state for _, nodes in table for node in nodes}
    if namespace:
        prefix = rosgraph.names.make_global_ns(namespace)
        found = {node for node in found if node.startswith(prefix)}
    return sorted(found)


def get_api_uri(master, caller_id, skip_cache=False):
    """URI of a node; None when there is none of that name."""
    try:
        return master.lookupNode(caller_id)
    except rosgraph.MasterException:
        return None
    except OSError:
        raise ROSNodeIOException("Unable to communicate with master!") from None


def _api(name):
    return rosgraph.Master("/rosnode").lookupNode(rosgraph.names.script_resolve_name("/rosnode", name))


def rosnode_ping(node_name, max_count=None, verbose=False):
    """True when the node answers; `max_count` tries, without it for ever while it does."""
    from rosproto.rospy.master import call

    try:
        uri = _api(node_name)
    except rosgraph.MasterException:
        if verbose:
            print("cannot ping [%s]: unknown node" % node_name, file=sys.stderr)
        return False
    count = 0
    while max_count is None or count < max_count:
        began = time.time()
        try:
            call(uri, "getPid", "/rosnode")
        except OSError:
            return False
        if verbose:
            print("xmlrpc reply from %s\ttime=%fms" % (uri, (time.time() - began) * 1000.0))
        count += 1
        if max_count is None or count < max_count:
            time.sleep(1.0)
    return True


def kill_nodes(node_names):
    """Ask nodes to end; (those that will, those that were not reached)."""
    from rosproto.rospy.master import call

    done, failed = [], []
    for name in node_names:
        try:
            call(_api(name), "shutdown", "/rosnode", "user request")
            done.append(name)
        except (OSError, rosgraph.MasterException):
            failed.append(name)
    return done, failed
