"""rostopic as far as programs import it: the types of topics."""

import rosgraph

__all__ = [
    "ROSTopicException",
    "ROSTopicIOException",
    "find_by_type",
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
