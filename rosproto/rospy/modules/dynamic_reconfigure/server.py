"""dynamic_reconfigure.server.Server: other nodes can set this node's parameters."""

import copy
import threading

import rospy

from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from dynamic_reconfigure.srv import Reconfigure as ReconfigureSrv

from . import DynamicReconfigureCallbackException
from .encoding import (
    decode_config,
    encode_config,
    encode_description,
    extract_params,
    get_tree,
    initial_config,
)

ALL_LEVELS = -1


class Server:
    """Calls `callback(config, level)` with every change; its return value is the new configuration.

    Args:
        type: The module generated from a .cfg file.
        namespace: Below the node's name, where the service and the topics are.
    """

    def __init__(self, type, callback, namespace=""):
        self.mutex = threading.Lock()
        if namespace and namespace[0] not in "/~":
            namespace = "~" + namespace
        self.ns = (namespace + "/").replace("//", "/") if namespace else "~"
        self.type = type
        self.config = type.defaults.copy()
        self.description = encode_description(type)
        for name in self._names():
            self.config[name] = rospy.get_param(self.ns + name, self.config[name])
        self.callback = callback
        self._clamp(self.config)
        self.config["groups"] = get_tree(self.description)
        self.config = initial_config(encode_config(self.config), type.config_description)
        self.descr_topic = rospy.Publisher(
            self.ns + "parameter_descriptions", ConfigDescrMsg, latch=True, queue_size=10
        )
        self.descr_topic.publish(self.description)
        self.update_topic = rospy.Publisher(
            self.ns + "parameter_updates", ConfigMsg, latch=True, queue_size=10
        )
        self._change_config(self.config, ALL_LEVELS)
        self.set_service = rospy.Service(self.ns + "set_parameters", ReconfigureSrv, self._set_callback)

    def _parameters(self):
        return extract_params(self.type.config_description)

    def _names(self):
        return [one["name"] for one in self._parameters()]

    def update_configuration(self, changes):
        """Set some parameters from the program itself; returns the resulting configuration."""
        with self.mutex:
            config = copy.deepcopy(self.config)
            config.update(changes)
            self._clamp(config)
            level = 0
            for one in self._parameters():
                if config[one["name"]] != self.config[one["name"]]:
                    level |= one["level"]
            return self._change_config(config, level)

    def _change_config(self, config, level):
        self.config = self.callback(config, level)
        if self.config is None:
            text = "Reconfigure callback should return a possibly updated configuration."
            rospy.logerr(text)
            raise DynamicReconfigureCallbackException(text)
        for name in self._names():
            rospy.set_param(self.ns + name, self.config[name])
        self.update_topic.publish(encode_config(self.config))
        return self.config

    def _clamp(self, config):
        for name in self._names():
            low, high = self.type.min[name], self.type.max[name]
            if high != "" and config[name] > high:
                config[name] = high
            elif low != "" and config[name] < low:
                config[name] = low

    def _set_callback(self, req):
        changes = decode_config(req.config, self.type.config_description)
        return encode_config(self.update_configuration(changes))
