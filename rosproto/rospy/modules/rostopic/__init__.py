"""rostopic as far as programs import it: types of topics, who is at them, how often and how much comes."""

import rosgraph

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
    """(type, topic, None) of a topic or of what is below its name; Nones when it is unknown."""
    import time

    while True:
        for name, type_ in _types():
            if topic == name or topic.startswith(name + "/"):
                return (None if type_ == "*" else type_), name, msgevalgen(topic[len(name) :])
        if not blocking:
            return None, None, None
        time.sleep(0.1)


def get_topic_class(topic, blocking=False):
    """(class, topic, None) of a topic; Nones when it is unknown."""
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
    """([(topic, type, [publishers])], [(topic, type, [subscribers])])."""
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
    """URI of a node, or a text that says it is unknown."""
    try:
        return master.lookupNode(caller_id)
    except rosgraph.MasterError:
        return "unknown address %s" % caller_id
    except OSError:
        raise ROSTopicIOException("Unable to communicate with master!") from None


def get_info_text(topic):
    """What `rostopic info` prints: the type, and who publishes and subscribes."""
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
    """(publisher, class) of a type's name; makes this process the node /rostopic_... when it is none."""
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


def msgevalgen(pattern):
    """A function that takes what a pattern like "/pose/position/x" or "/ranges[0]" names out of a message."""
    if not pattern or pattern == "/":
        return None
    names = [part for part in pattern.split("/") if part]

    def evaluate(message):
        for name in names:
            name, _, index = name.partition("[")
            message = getattr(message, name)
            if index:
                message = message[int(index.rstrip("]"))]
        return message

    return evaluate
