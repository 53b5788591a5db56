"""rosnode as far as programs import it: names of nodes, where they run, ping, kill, cleaning up."""

import socket
import sys
import time
from urllib.parse import urlsplit

import rosgraph

from rosproto.rospy.master import call


class ROSNodeException(Exception):
    """A node cannot be used."""


class ROSNodeIOException(ROSNodeException):
    """The master cannot be reached."""


def _succeed(args):
    """The value in a reply of the master or a node."""
    code, text, value = args
    if code != 1:
        raise ROSNodeException("remote call failed: %s" % text)
    return value


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


def rosnode_listnodes(namespace=None, list_uri=False, list_all=False):
    """Print names of nodes, their URIs, or both."""
    print(_sub_rosnode_listnodes(namespace, list_uri, list_all))


def _sub_rosnode_listnodes(namespace=None, list_uri=False, list_all=False):
    """Return what `rosnode_listnodes` prints; programs use this private function."""
    master = rosgraph.Master("/rosnode")
    rows = names = get_node_names(namespace)
    if list_uri or list_all:
        rows = [get_api_uri(master, name) or "unknown address" for name in names]
    if list_all:
        rows = ["%s \t%s" % row for row in zip(rows, names)]
    return "\n".join(rows)


def _hosts():
    """(node, host of its URI)."""
    master = rosgraph.Master("/rosnode")
    for name in get_node_names():
        uri = get_api_uri(master, name)
        if uri:  # it may have ended
            yield name, urlsplit(uri).hostname


def get_machines_by_nodes():
    """The hosts on which nodes run, each once."""
    return list(dict.fromkeys(host for _, host in _hosts()))


def _addresses(host):
    return {entry[4][0] for entry in socket.getaddrinfo(host, 0, 0, 0, socket.IPPROTO_TCP)}


def get_nodes_by_machine(machine):
    """Names of the nodes on a host.

    Raises:
        ROSNodeException: The host's name is unknown.
    """
    try:
        wanted = _addresses(machine)
    except OSError:
        raise ROSNodeException("cannot resolve machine name [%s] to address" % machine) from None
    return [name for name, host in _hosts() if host == machine or wanted & _addresses(host)]


def get_node_info_description(node_name):
    """Return the master's information about a node, as `rosnode info` prints it."""
    master = rosgraph.Master("/rosnode")
    try:
        state = master.getSystemState()
        types = dict(master.getPublishedTopics("/"))
    except OSError:
        raise ROSNodeIOException("Unable to communicate with master!") from None
    text = "Node [%s]" % node_name
    for title, table in zip(("Publications", "Subscriptions", "Services"), state):
        names = sorted(name for name, nodes in table if node_name in nodes)
        rows = [" * %s" % name for name in names]
        if title != "Services":
            rows = ["%s [%s]" % (row, types.get(name, "unknown type")) for row, name in zip(rows, names)]
        text += "\n%s: %s\n" % (title, "\n" + "\n".join(rows) if rows else "None")
    return text


def get_api_uri(master, caller_id, skip_cache=False):
    """URI of a node; None when there is none of that name."""
    try:
        return master.lookupNode(caller_id)
    except rosgraph.MasterException:
        return None
    except OSError:
        raise ROSNodeIOException("Unable to communicate with master!") from None


def rosnode_ping(node_name, max_count=None, verbose=False, skip_cache=False):
    """True when the node answers. Makes `max_count` tries; without it, goes on as long as it answers."""
    uri = get_api_uri(rosgraph.Master("/rosnode"), node_name)
    if not uri:
        print("cannot ping [%s]: unknown node" % node_name, file=sys.stderr)
        return False
    if verbose:
        print("pinging %s with a timeout of 3.0s" % node_name)
    times = []
    while True:
        began = time.monotonic()
        try:
            call(uri, "getPid", "/rosnode")
        except OSError as error:
            refused = isinstance(error, ConnectionRefusedError)
            texts = "connection to [%s] failed" % node_name, "ERROR: connection refused to [%s]" % uri
            print(texts[refused], file=sys.stderr)
            return False
        times.append((time.monotonic() - began) * 1000.0)
        if verbose:
            print("xmlrpc reply from %s\ttime=%fms" % (uri, times[-1]))
        if max_count and len(times) >= max_count:
            break
        try:
            time.sleep(1.0)
        except KeyboardInterrupt:
            break
    if verbose and len(times) > 1:
        print("ping average: %fms" % (sum(times) / len(times)))
    return True


def rosnode_ping_all(verbose=False, skip_cache=False):
    """(nodes that answer, nodes that do not)."""
    names = get_node_names()
    if verbose:
        print("Will ping the following nodes: \n" + "".join(" * %s\n" % name for name in names))
    answers = {name: rosnode_ping(name, max_count=1, verbose=verbose) for name in names}
    return [name for name in names if answers[name]], [name for name in names if not answers[name]]


def _unregister(master, unwanted):
    publishers, subscribers, services = master.getSystemState()
    for table, what in ((publishers, "unregisterPublisher"), (subscribers, "unregisterSubscriber")):
        for name, nodes in table:
            for node in filter(unwanted, nodes):
                getattr(rosgraph.Master(node), what)(name, get_api_uri(master, node))
    for name, nodes in services:
        for node in filter(unwanted, nodes):
            rosgraph.Master(node).unregisterService(name, master.lookupService(name))


def cleanup_master_blacklist(master, blacklist):
    """Remove the registrations of these dead nodes from the master."""
    for name in blacklist:
        print("Unregistering", name)
        _unregister(master, name.__eq__)


def cleanup_master_whitelist(master, whitelist):
    """The same for all nodes but these."""
    _unregister(master, lambda name: name not in whitelist)


def rosnode_cleanup():
    """Remove the nodes that do not answer from the master, after asking on the terminal."""
    unpinged = rosnode_ping_all()[1]
    if not unpinged:
        return
    print("Unable to contact the following nodes:")
    print("\n".join(" * %s" % name for name in unpinged))
    print("Warning: these might include alive and functioning nodes, e.g. in unstable networks.")
    print("Cleanup will purge all information about these nodes from the master.")
    print("Please type y or n to continue:")
    answer = ""
    while answer not in ("y", "n"):
        line = sys.stdin.readline()
        answer = line.strip() if line else "n"  # rosnode reads for ever when its input has ended
    if answer == "n":
        print("aborting")
        return
    cleanup_master_blacklist(rosgraph.Master("/rosnode"), unpinged)
    print("done")


def kill_nodes(node_names):
    """Ask nodes to shut down; returns (those that will, those that were not reached)."""
    done, failed = [], []
    for name in node_names:
        try:
            node = rosgraph.names.script_resolve_name("/rosnode", name)
            call(rosgraph.Master("/rosnode").lookupNode(node), "shutdown", "/rosnode", "user request")
            done.append(name)
        except (OSError, rosgraph.MasterException):
            failed.append(name)
    return done, failed
