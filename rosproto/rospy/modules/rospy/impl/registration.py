"""rospy.impl.registration: the tables of this node's topics and services."""


class Registration:
    """Kinds of registrations."""

    PUB = "pub"
    SUB = "sub"
    SRV = "srv"


def get_topic_manager():
    """The table of topics."""
    from rospy.topics import manager

    return manager


def get_service_manager():
    """The table of services."""
    from rospy.service import manager

    return manager
