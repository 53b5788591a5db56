"""rospy.msproxy: the master API with resolved names and this node's caller id; parameters as in a dict."""

import threading

from rosproto.rospy.master import call

from . import core, names
from .exceptions import ROSException


class MasterProxy:
    """All methods of the master API, and `master[key]` for parameters."""

    def __init__(self, uri):
        self._uri = uri
        self._cached = {}
        self._lock = threading.Lock()

    @property
    def target(self):
        """The master as an `xmlrpc.client.ServerProxy`."""
        return core.xmlrpcapi(self._uri)

    def is_cached(self, key):
        """True if `get_param_cached` was called for this global name."""
        return key in self._cached

    def __getattr__(self, key):
        if key.startswith("__"):
            raise AttributeError(key)

        def method(*args):
            if args:  # of every method that takes any, the first is a name
                args = (names.resolve_name(args[0]), *args[1:])
            return self._call(key, *args)

        return method

    def _call(self, method, *args):
        with core.uninterrupted:
            return call(self._uri, method, names.get_caller_id(), *args)

    def __getitem__(self, key):
        code, _, value = self._call("getParam", names.resolve_name(key))
        if code != 1:
            raise KeyError(key)
        return value

    def __setitem__(self, key, value):
        self._call("setParam", names.resolve_name(key), value)

    def __delitem__(self, key):
        code, text, _ = self._call("deleteParam", names.resolve_name(key))
        if code == -1:
            raise KeyError(key)
        if code != 1:
            raise ROSException("cannot delete parameter: %s" % text)

    def __contains__(self, key):
        code, text, value = self._call("hasParam", names.resolve_name(key))
        if code != 1:
            raise ROSException("cannot check parameter on server: %s" % text)
        return value

    def __iter__(self):
        code, text, value = self._call("getParamNames")
        if code != 1:
            raise ROSException("cannot retrieve parameter names: %s" % text)
        return iter(value)

    def search_param(self, key):
        """Name of the parameter found in this or a parent namespace; None if not found."""
        key = names.get_mappings().get(key, key)
        code, text, value = self._call("searchParam", key)
        if code == 1:
            return value
        if code == -1:
            return None
        raise ROSException("cannot search for parameter: %s" % text)

    def get_param_cached(self, key):
        """Value of a parameter; fetched once, then updated by the master."""
        from .impl import init

        resolved = names.resolve_name(key)
        if init.node is None:
            return self[key]
        with self._lock:
            if resolved not in self._cached:
                self._cached[resolved] = None
                init.node.params.subscribe(resolved, lambda *_: None)
        value = init.node.params.get(resolved)
        if value is None or value == {}:
            raise KeyError(key)
        return value
