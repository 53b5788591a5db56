"""dynamic_reconfigure.client.Client: sets the parameters of another node."""

import threading
import time

import rospy

from dynamic_reconfigure.msg import Config, ConfigDescription
from dynamic_reconfigure.srv import Reconfigure

from . import DynamicReconfigureParameterException
from .encoding import decode_config, decode_description, encode_config


class Client:
    """Talks to one node that can be reconfigured."""

    def __init__(self, name, timeout=None, config_callback=None, description_callback=None):
        self.name = name
        self.config = None
        self.param_description = None
        self.config_callback = config_callback
        self.description_callback = description_callback
        self._changed = threading.Condition()
        self._set_service = rospy.ServiceProxy(self._name("set_parameters"), Reconfigure)
        if timeout is None or timeout > 0:
            rospy.wait_for_service(self._name("set_parameters"), timeout)
        self._descriptions_sub = rospy.Subscriber(
            self._name("parameter_descriptions"), ConfigDescription, self._on_description
        )
        self._updates_sub = rospy.Subscriber(self._name("parameter_updates"), Config, self._on_update)

    def _name(self, suffix):
        return "%s/%s" % (rospy.resolve_name(self.name), suffix)

    def get_configuration(self, timeout=None):
        """The present configuration as a dict; None when it did not come in time."""
        return self._wait(lambda: self.config, timeout)

    def get_parameter_descriptions(self, timeout=None):
        """A dict for each parameter; None when they did not come in time."""
        return self._wait(lambda: self.param_description, timeout)

    def _wait(self, value, timeout):
        end = None if timeout is None else time.time() + timeout
        with self._changed:
            while value() is None and not rospy.is_shutdown():
                if end is not None and time.time() > end:
                    return None
                self._changed.wait(0.1)
        return value()

    def update_configuration(self, changes):
        """Set some parameters; the configuration that results.

        Raises:
            DynamicReconfigureParameterException: One of them is unknown, or its value does not fit.
        """
        known = {one["name"]: one["type"] for one in self.get_parameter_descriptions() or []}
        values = {}
        for name, value in changes.items():
            if name not in known:
                raise DynamicReconfigureParameterException("don't know parameter: %s" % name)
            values[name] = self._converted(name, known[name], value)
        self.config = decode_config(self._set_service(encode_config(values)).config)
        return self.config

    @staticmethod
    def _converted(name, type_, value):
        try:
            if type_ == "bool":
                if isinstance(value, str):
                    return value.lower() in ("true", "1")
                return bool(value)
            return {"int": int, "double": float, "str": str}[type_](value)
        except (ValueError, TypeError):
            raise DynamicReconfigureParameterException(
                "can't set parameter '%s' of type %s: %s" % (name, type_, value)
            )

    def update_groups(self, changes):
        """Groups are not kept: they only order the parameters on a screen."""
        return self.get_configuration()

    def set_config_callback(self, value):
        """Call `value(config)` with every change."""
        self.config_callback = value
        if value is not None and self.config is not None:
            value(self.config)

    def set_description_callback(self, value):
        """Call `value(description)` when it comes."""
        self.description_callback = value
        if value is not None and self.param_description is not None:
            value(self.param_description)

    def close(self):
        """Listen no more."""
        self._descriptions_sub.unregister()
        self._updates_sub.unregister()

    def _on_update(self, message):
        with self._changed:
            self.config = decode_config(message)
            self._changed.notify_all()
        if self.config_callback is not None:
            self.config_callback(self.config)

    def _on_description(self, message):
        with self._changed:
            self.param_description = decode_description(message)
            self._changed.notify_all()
        if self.description_callback is not None:
            self.description_callback(self.param_description)
