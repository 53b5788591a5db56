"""dynamic_reconfigure.client.Client: sets the parameters of another node."""

import ast
import sys
import threading
import time

import rospy

from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from dynamic_reconfigure.srv import Reconfigure as ReconfigureSrv

from . import DynamicReconfigureCallbackException, DynamicReconfigureParameterException
from .encoding import decode_config, decode_description, encode_config, extract_params

_TYPES = {"int": int, "double": float, "str": str, "bool": bool}
SLICE = 0.1  # seconds between checks for shutdown


class Client:
    """Talks to one node that can be reconfigured."""

    def __init__(self, name, timeout=None, config_callback=None, description_callback=None):
        self.name = name
        self.config = None
        self.param_description = None
        self.group_description = None
        self._param_types = None
        self._cv = threading.Condition()
        self._config_callback = config_callback
        self._description_callback = description_callback
        self._set_service = self._get_service_proxy("set_parameters", timeout)
        self._descriptions_sub = self._get_subscriber(
            "parameter_descriptions", ConfigDescrMsg, self._descriptions_msg
        )
        self._updates_sub = self._get_subscriber("parameter_updates", ConfigMsg, self._updates_msg)

    def _get_service_proxy(self, suffix, timeout):
        service = rospy.resolve_name(self.name + "/" + suffix)
        if timeout:
            rospy.wait_for_service(service, timeout)
        else:
            try:
                rospy.wait_for_service(service, 1.0)
            except rospy.exceptions.ROSException:
                print("Waiting for service %s..." % service, file=sys.stderr)
                rospy.wait_for_service(service, timeout)
        return rospy.ServiceProxy(service, ReconfigureSrv)

    def _get_subscriber(self, suffix, type, callback):
        return rospy.Subscriber(rospy.resolve_name(self.name + "/" + suffix), type, callback=callback)

    # -- asking ---------------------------------------------------------------------------------------------

    def get_configuration(self, timeout=None):
        """The newest configuration, a dict with attributes; None when time is up."""
        if not timeout and self._waited("config", 1.0) is None:
            print("Waiting for configuration...", file=sys.stderr)
        return self._waited("config", timeout)

    def get_parameter_descriptions(self, timeout=None):
        """A dict for each parameter; None when time is up."""
        return self._waited("param_description", timeout)

    def get_group_descriptions(self, timeout=None):
        """The tree of groups; None when time is up."""
        return self._waited("group_description", timeout)

    def _waited(self, attribute, timeout):
        end = time.monotonic() + timeout if timeout else None
        with self._cv:
            while getattr(self, attribute) is None and not rospy.is_shutdown():
                left = SLICE if end is None else min(SLICE, end - time.monotonic())
                if left <= 0.0:
                    break
                self._cv.wait(left)
        return None if rospy.is_shutdown() else getattr(self, attribute)

    # -- setting --------------------------------------------------------------------------------------------

    def update_configuration(self, changes):
        """Set some parameters; returns the resulting configuration.

        Raises:
            DynamicReconfigureParameterException: One of them is unknown, or its value does not fit.
        """
        if self.param_description is None:
            self.get_parameter_descriptions()
        if self.param_description is not None:
            for name, value in list(changes.items()):
                if name != "groups":
                    changes[name] = self._converted(name, value)
        if "groups" in changes:
            changes["groups"] = self.update_groups(changes["groups"])
        try:
            reply = self._set_service(encode_config(changes)).config
        except rospy.ServiceException:
            raise DynamicReconfigureCallbackException("service call failed") from None
        if self.group_description is None:
            self.get_group_descriptions()
        return decode_config(reply, self.group_description)

    def _converted(self, name, value):
        type_ = self._param_types.get(name)
        if type_ is None:
            raise DynamicReconfigureParameterException("don't know parameter: %s" % name)
        try:
            if isinstance(value, str):
                if type_ is bool:
                    return value.lower() in ("yes", "true", "t", "1")
                constant = self._constant(name, value)
                if constant is not None:
                    return constant
            return type_(value)
        except ValueError as error:
            raise DynamicReconfigureParameterException(
                "can't set parameter '%s' of %s: %s" % (name, type_, error)
            ) from None

    def _constant(self, name, value):
        """The value of an enumeration's name."""
        described = next(one for one in self.param_description if one["name"].lower() == name.lower())
        if not described["edit_method"]:
            return None
        for constant in ast.literal_eval(described["edit_method"])["enum"]:
            if constant["name"].lower() == value.lower():
                return _TYPES[constant["type"]](constant["value"])
        return None

    def update_groups(self, changes):
        """The groups with the given states: {name: state}."""
        groups = self.get_configuration()["groups"]

        def update(group):
            for name, inner in group["groups"].items():
                if name in changes:
                    inner["state"] = changes[name]
                update(inner)

        update(groups)
        return groups

    def close(self):
        """Unsubscribe."""
        self._descriptions_sub.unregister()
        self._updates_sub.unregister()

    # -- callbacks ------------------------------------------------------------------------------------------

    def get_config_callback(self):
        """What is called with every new configuration."""
        return self._config_callback

    def set_config_callback(self, value):
        """Set it; it is called with the current configuration now."""
        self._config_callback = value
        if value is not None:
            value(self.config)

    config_callback = property(get_config_callback, set_config_callback)

    def get_description_callback(self):
        """What is called with every new description."""
        return self._description_callback

    def set_description_callback(self, value):
        """Set it; it is called with the current description now."""
        self._description_callback = value
        if value is not None:
            value(self.param_description)

    description_callback = property(get_description_callback, set_description_callback)

    def _updates_msg(self, msg):
        if self.group_description is None:
            self.get_group_descriptions()
        with self._cv:
            self.config = decode_config(msg, self.group_description)
            self._cv.notify_all()
        if self._config_callback is not None:
            self._config_callback(self.config)

    def _descriptions_msg(self, msg):
        with self._cv:
            self.group_description = decode_description(msg)
            self.param_description = extract_params(self.group_description)
            self._param_types = {one["name"]: _TYPES[one["type"]] for one in self.param_description}
            self._cv.notify_all()
        if self._description_callback is not None:
            self._description_callback(self.param_description)
