"""rospy.impl.registration: the tables of this node's topics and services, and who is told of changes."""

import threading
import traceback

from . import _unserved

RegManager = _unserved.class_of("rospy.impl.registration.RegManager")
set_topic_manager = _unserved.function("rospy.impl.registration.set_topic_manager")
set_service_manager = _unserved.function("rospy.impl.registration.set_service_manager")


class Registration:
    """Kinds of registrations."""

    PUB = "pub"
    SUB = "sub"
    SRV = "srv"


class RegistrationListener:
    """Told when this node begins or ends to publish, subscribe or provide; derive from it."""

    def reg_added(self, resolved_name, data_type_or_uri, reg_type):
        """It has begun: the type of a topic, the URI of a service."""

    def reg_removed(self, resolved_name, data_type_or_uri, reg_type):
        """It has ended."""


class RegistrationListeners:
    """Those that are told."""

    def __init__(self):
        self.listeners = []
        self.lock = threading.Lock()

    def add_listener(self, l):  # noqa: E741  rospy's name of it
        """Tell this one too."""
        assert isinstance(l, RegistrationListener)
        with self.lock:
            self.listeners = [*self.listeners, l]

    def clear(self):
        """Tell nobody any more."""
        with self.lock:
            self.listeners = []

    def notify_added(self, resolved_name, data_type, reg_type):
        """Tell all."""
        self._notify("reg_added", resolved_name, data_type, reg_type)

    def notify_removed(self, resolved_name, data_type_or_uri, reg_type):
        """Tell all."""
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
    """Those of this node."""
    return _listeners


def get_topic_manager():
    """The table of topics."""
    from rospy.topics import manager

    return manager


def get_service_manager():
    """The table of services."""
    from rospy.service import manager

    return manager
