"""The master's API: unpacks the triples and raises errors.

Source: wiki.ros.org/ROS/Master_API.
"""

from rosproto.rospy.master import call

from .names import make_caller_id
from .network import parse_http_host_and_port
from .rosenv import get_master_uri


class MasterException(Exception):
    """Base of a master's errors."""


class MasterFailure(MasterException):
    """The master failed."""


class MasterError(MasterException):
    """The master refused: an argument is wrong, or the requested item does not exist."""


ROSMasterException = MasterException
Error = MasterError
Failure = MasterFailure

_METHODS = {  # and rosgraph's names of their arguments
    "deleteParam": "key",
    "getParam": "key",
    "getParamNames": "",
    "getPid": "",
    "getPublishedTopics": "subgraph",
    "getSystemState": "",
    "getTopicTypes": "",
    "getUri": "",
    "hasParam": "key",
    "lookupNode": "node_name",
    "lookupService": "service",
    "registerPublisher": "topic topic_type caller_api",
    "registerService": "service service_api caller_api",
    "registerSubscriber": "topic topic_type caller_api",
    "searchParam": "key",
    "setParam": "key value",
    "subscribeParam": "caller_api key",
    "unregisterPublisher": "topic caller_api",
    "unregisterService": "service service_api",
    "unregisterSubscriber": "topic caller_api",
    "unsubscribeParam": "caller_api key",
}


def is_online(master_uri=None):
    """True when a master answers."""
    return Master("rosgraph", master_uri=master_uri).is_online()


class Master:
    """A master; has every method of its API, without the caller id."""

    def __init__(self, caller_id, master_uri=None):
        self._reinit(get_master_uri() if master_uri is None else master_uri)
        self.caller_id = make_caller_id(caller_id).rstrip("/") or "/"

    def _reinit(self, master_uri):
        try:
            parse_http_host_and_port(master_uri)
        except ValueError:
            raise ValueError("invalid master URI: %s" % master_uri) from None
        self.master_uri = master_uri

    def _call(self, method, *args):
        code, text, value = call(self.master_uri, method, self.caller_id, *args)
        if code == 1:
            return value
        if code == -1:
            raise MasterError(text)
        raise MasterFailure(text)

    def is_online(self):
        """True when the master answers."""
        try:
            self.getPid()
            return True
        except (OSError, MasterException):
            return False


def _method(name, expected):
    def method(self, *args, **kwds):
        args += tuple(kwds.pop(one) for one in expected[len(args) :] if one in kwds)
        if kwds or len(args) != len(expected):
            raise TypeError("%s() takes these arguments: %s" % (name, ", ".join(expected) or "none"))
        return self._call(name, *args)

    method.__name__ = name
    method.__doc__ = "The master's %s." % name
    return method


for _name, _arguments in _METHODS.items():
    setattr(Master, _name, _method(_name, _arguments.split()))
