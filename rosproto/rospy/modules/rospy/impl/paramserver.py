"""rospy.impl.paramserver: the values that `rospy.get_param_cached` keeps up to date."""


class ParamServerCache:
    """Values by global name."""

    def __init__(self):
        self._set = {}

    def get(self, key):
        """The present value.

        Raises:
            KeyError: `get_param_cached` was not called for it, or it is not set.
        """
        if key in self._set:
            return self._set[key]
        from rospy import client

        if not client.get_master().is_cached(key):
            raise KeyError(key)
        return client.get_param_cached(key)

    def set(self, key, value):
        """Set the value that `get` returns."""
        self._set[key] = value

    def update(self, key, value):
        """The same, but a KeyError when `get` does not know the key."""
        self.get(key)
        self.set(key, value)

    def delete(self, key):
        """Delete a value set here.

        Raises:
            KeyError: It was not set here.
        """
        del self._set[key]


_cache = ParamServerCache()


def get_param_server_cache():
    """Return the cache of this process."""
    return _cache
