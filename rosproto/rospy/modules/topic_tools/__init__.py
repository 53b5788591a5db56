"""topic_tools: LazyTransport; its services are in topic_tools.srv."""

import threading

import rospy


class _Finished(type):
    """Subscribes at once when it is not lazy, after the constructors of derived classes."""

    def __call__(cls, *args, **kwargs):
        made = super().__call__(*args, **kwargs)
        if not rospy.get_param("~lazy", True):
            made._begin()
        return made


class LazyTransport(rospy.SubscribeListener, metaclass=_Finished):
    """Base class of programs that subscribe only as long as somebody subscribes to what they publish.

    Derived classes have `subscribe()` and `unsubscribe()`, and publish by `advertise(...)`. With the
    parameter ~lazy set to false they subscribe at once.
    """

    def __init__(self):
        self._publishers = []
        self._subscribed = None  # False: it has subscribed before
        self._lock = threading.RLock()
        rospy.Timer(rospy.Duration(5), self._warn_if_never, oneshot=True)

    def _warn_if_never(self, event):
        if self._subscribed is None:
            rospy.logwarn(
                "[%s] subscribes topics only with child subscribers. Set '~lazy' as False to have it always"
                " transport message.",
                rospy.get_name(),
            )

    def subscribe(self):
        """Begin to subscribe."""
        raise NotImplementedError

    def unsubscribe(self):
        """End it."""
        raise NotImplementedError

    def is_subscribed(self):
        """True while it subscribes."""
        return bool(self._subscribed)

    def advertise(self, *args, **kwargs):
        """A rospy.Publisher whose subscribers count."""
        if len(args) >= 3:
            raise ValueError("subscriber_listener is set by LazyTransport: give the other arguments by name")
        publisher = rospy.Publisher(*args, subscriber_listener=self, **kwargs)
        self._publishers.append(publisher)
        return publisher

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """The first subscriber begins it."""
        self._begin()

    def peer_unsubscribe(self, topic_name, num_peers):
        """The last one ends it."""
        with self._lock:
            wanted = any(one.get_num_connections() for one in self._publishers)
            if self._subscribed and not wanted and rospy.get_param("~lazy", True):
                self._subscribed = False
                self.unsubscribe()

    def _begin(self):
        with self._lock:
            if not self._subscribed:
                self._subscribed = True
                self.subscribe()
