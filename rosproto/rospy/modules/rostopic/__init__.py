"""rostopic's functions for programs: types, peers, rates and bandwidth of topics."""

import sys

import rosgraph

from .fields import msgevalgen
from .measure import ROSTopicBandwidth, ROSTopicDelay, ROSTopicHz

__all__ = [
    "ROSTopicBandwidth",
    "ROSTopicDelay",
    "ROSTopicException",
    "ROSTopicHz",
    "ROSTopicIOException",
    "create_publisher",
    "find_by_type",
    "get_api",
    "get_info_text",
    "get_topic_class",
    "get_topic_list",
    "get_topic_type",
    "msgevalgen",
]


class ROSTopicException(Exception):
    """A topic or its type cannot be used."""


class ROSTopicIOException(ROSTopicException):
    """The master cannot be reached."""


def _types():
    try:
        return rosgraph.Master("/rostopic").getTopicTypes()
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None


def get_topic_type(topic, blocking=False):
    """(type, topic, function) of a topic, or of a field appended to its name; Nones if unknown.

    The function extracts the field from a message; None without a field.
    """
    import time

    import rospy

    found = _typed(topic)
    if blocking and found[0] is None:
        sys.stderr.write("WARNING: topic [%s] does not appear to be published yet\n" % topic)
        while found[0] is None and not rospy.is_shutdown():
            time.sleep(0.1)
            found = _typed(topic)
    return found


def _typed(topic):
    known = dict(_types())
    name = topic if topic in known else None
    if name is None:
        # Longest name first; skip topics whose messages do not have the field.
        below = sorted((one for one in known if topic.startswith(one + "/")), reverse=True)
        name = next((one for one in below if _has_field(known[one], topic[len(one) + 1 :])), None)
    if name is None or known[name] == "*":
        return None, None, None
    return known[name], name, msgevalgen(topic[len(name) :])


def _has_field(type_, path):
    """True if messages of a type have the field (up to the first bracket), or the type is unknown."""
    from genpy.message import get_message_class

    found = get_message_class(type_)
    message = found() if found else None
    for name in path.rstrip("/").partition("[")[0].split("/"):
        if message is None or not name:
            break
        if not hasattr(message, name):
            return False
        message = getattr(message, name)
    return True


def get_topic_class(topic, blocking=False):
    """(class, topic, None) of a topic; Nones if unknown."""
    from genpy.message import get_message_class

    type_, name, function = get_topic_type(topic, blocking)
    if type_ is None:
        return None, None, None
    found = get_message_class(type_)
    if not found:
        raise ROSTopicException("Cannot load message class for [%s]. Are your messages built?" % type_)
    return found, name, function


def find_by_type(topic_type):
    """Names of the topics of a type."""
    return [name for name, type_ in _types() if type_ == topic_type]


def get_topic_list(master=None):
    """Return ([(topic, type, [publishers])], [(topic, type, [subscribers])])."""
    master = master or rosgraph.Master("/rostopic")
    try:
        publishers, subscribers, _ = master.getSystemState()
        types = dict(master.getTopicTypes())
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None
    return tuple(
        [(topic, types.get(topic, "unknown type"), nodes) for topic, nodes in table]
        for table in (publishers, subscribers)
    )


def get_api(master, caller_id):
    """URI of a node, or a text for an unknown node."""
    try:
        return master.lookupNode(caller_id)
    except rosgraph.MasterError:
        return "unknown address %s" % caller_id
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None


def get_info_text(topic):
    """Output of `rostopic info`: type, publishers and subscribers."""
    master = rosgraph.Master("/rostopic")
    tables = [[row for row in table if row[0] == topic] for table in get_topic_list(master)]
    if not any(tables):
        raise ROSTopicException("Unknown topic %s" % topic)
    text = "Type: %s\n\n" % next(row[1] for table in tables for row in table)
    for title, table in zip(("Publishers", "Subscribers"), tables):
        nodes = [node for row in table for node in row[2]]
        text += "%s: %s\n" % (title, "" if nodes else "None")
        text += "".join(" * %s (%s)\n" % (node, get_api(master, node)) for node in nodes) + "\n"
    return text


def create_publisher(topic_name, topic_type, latch, disable_rostime=True):
    """(publisher, class) for a type name; starts the node /rostopic_... if this process has no node."""
    import rospy
    from genpy.message import get_message_class

    try:
        found = get_message_class(topic_type)
    except ValueError:
        raise ROSTopicException("invalid topic type: %s" % topic_type) from None
    if found is None:
        raise ROSTopicException(
            "invalid message type: %s.\nIf this is a valid message type, give its folder by --msg-path"
            % topic_type
        )
    rospy.init_node("rostopic", anonymous=True, disable_rosout=True, disable_rostime=disable_rostime)
    name = rosgraph.names.script_resolve_name("rostopic", topic_name)
    return rospy.Publisher(name, found, latch=latch, queue_size=100), found
