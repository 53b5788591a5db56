"""rospy.impl.registration: the tables of this node's topics and services, and listeners to changes."""

import threading
import traceback

from .. import service
from ._unserved import unserved

RegManager = unserved("rospy.impl.registration.RegManager")
set_topic_manager = unserved("rospy.impl.registration.set_topic_manager")
set_service_manager = unserved("rospy.impl.registration.set_service_manager")


class Registration:
    """Kinds of registrations."""

    PUB = "pub"
    SUB = "sub"
    SRV = "srv"


class RegistrationListener:
    """Base of listeners: called when a topic or service of this node is registered or unregistered."""

    def reg_added(self, resolved_name, data_type_or_uri, reg_type):
        """Something was registered; `data_type_or_uri` is a topic's type or a service's URI."""

    def reg_removed(self, resolved_name, data_type_or_uri, reg_type):
        """Something was unregistered."""


class RegistrationListeners:
    """The listeners."""

    def __init__(self):
        self.listeners = []
        self.lock = threading.Lock()

    def add_listener(self, l):  # noqa: E741  rospy's name of it
        """Add a listener."""
        assert isinstance(l, RegistrationListener)
        with self.lock:
            self.listeners = [*self.listeners, l]

    def clear(self):
        """Remove all listeners."""
        with self.lock:
            self.listeners = []

    def notify_added(self, resolved_name, data_type, reg_type):
        """Notify all listeners."""
        self._notify("reg_added", resolved_name, data_type, reg_type)

    def notify_removed(self, resolved_name, data_type_or_uri, reg_type):
        """Notify all listeners."""
        self._notify("reg_removed", resolved_name, data_type_or_uri, reg_type)

    def _notify(self, method, *arguments):
        for listener in self.listeners:
            try:
                getattr(listener, method)(*arguments)
            except Exception:
                from rospy import core

                core.logerr("error notifying listener: %s" % traceback.format_exc())


_listeners = RegistrationListeners()


def get_registration_listeners():
    """The listeners of this node."""
    return _listeners


def get_topic_manager():
    """The table of topics."""
    from rospy.topics import manager

    return manager


def get_service_manager():
    """The table of services."""
    return service.manager
