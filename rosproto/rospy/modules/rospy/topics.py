"""rospy.topics: Publisher and Subscriber.

All publishers of a topic in this process share one implementation, as do all subscribers: one registration,
one connection per peer, callbacks in sequence in the receiving thread. They may be created before init_node,
which attaches the implementation to the node.
"""

import threading
import traceback
import warnings

import genpy

from rosproto.errors import MasterError, RosError
from rosproto.names import is_usable_name

from . import core, names
from ._topics import PublisherImpl, SubscriberImpl, TopicImpl
from .exceptions import ROSException, ROSSerializationException
from .impl.registration import Registration, get_registration_listeners, get_topic_manager
from .impl.tcpros_base import DEFAULT_BUFF_SIZE
from .msg import args_kwds_to_message


class TopicManager:
    """The topics of this process."""

    def __init__(self):
        self.pubs = {}
        self.subs = {}
        self.lock = threading.RLock()
        self._node = None

    def attach(self, node):
        """Use the node, and open the topics made before it existed."""
        with self.lock:
            self._node = node
            for impl in [*self.pubs.values(), *self.subs.values()]:
                self._open(impl)

    def _table(self, reg_type):
        return self.pubs if reg_type == Registration.PUB else self.subs

    def acquire_impl(self, reg_type, resolved_name, data_class, options):
        """The implementation of a topic, created with the first use; `options(impl)` sets it up."""
        with self.lock:
            table = self._table(reg_type)
            impl = table.get(resolved_name)
            if impl is None:
                kind = PublisherImpl if reg_type == Registration.PUB else SubscriberImpl
                impl = kind(resolved_name, data_class)
                options(impl)
                if self._node is not None:
                    self._open(impl)
                table[resolved_name] = impl
                get_registration_listeners().notify_added(resolved_name, impl.type, reg_type)
            else:
                options(impl)
            impl.ref_count += 1
            return impl

    def _open(self, impl):
        try:
            if is_usable_name(impl.resolved_name):
                impl.attach(self._node)
            else:
                self._refuse(impl, "ERROR: parameter [topic] contains illegal chars")
        except MasterError as error:
            self._refuse(impl, error.text)
        except (RosError, OSError) as error:
            if not core.is_shutdown():
                raise ROSException("cannot register [%s]: %s" % (impl.resolved_name, error)) from error

    @staticmethod
    def _refuse(impl, text):
        """Mark a topic as refused; the program continues without it, as in rospy."""
        impl.refused = True
        core.logfatal("unable to register %s [%s] with master: %s" % (impl.KIND, impl.resolved_name, text))

    def release_impl(self, reg_type, resolved_name):
        """Release a topic; the last release closes it."""
        with self.lock:
            table = self._table(reg_type)
            impl = table.get(resolved_name)
            if impl is None:
                return
            impl.ref_count -= 1
            if impl.ref_count:
                return
            del table[resolved_name]
        impl.close()
        get_registration_listeners().notify_removed(resolved_name, impl.type, reg_type)

    def get_impl(self, reg_type, resolved_name):
        """The implementation of a topic, None when there is none."""
        return self._table(reg_type).get(resolved_name)

    def has_subscription(self, resolved_name):
        """True when it is subscribed here."""
        return resolved_name in self.subs

    def has_publication(self, resolved_name):
        """True when it is published here."""
        return resolved_name in self.pubs

    def get_topics(self):
        """Names of all topics."""
        return {*self.pubs, *self.subs}

    def get_publications(self):
        """[[topic, type], ...]."""
        return [[name, impl.type] for name, impl in list(self.pubs.items())]

    def get_subscriptions(self):
        """[[topic, type], ...]."""
        return [[name, impl.type] for name, impl in list(self.subs.items())]


manager = TopicManager()


Message = genpy.Message
# rospy's names for them
_PublisherImpl, _SubscriberImpl, _TopicImpl = PublisherImpl, SubscriberImpl, TopicImpl
_TopicManager = TopicManager


class Topic:
    """Base class of Publisher and Subscriber."""

    def __init__(self, name, data_class, reg_type, options):
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        if data_class is None:
            raise ValueError("topic parameter 'data_class' is not initialized")
        if not isinstance(data_class, type):
            raise ValueError("data_class [%s] is not a class" % data_class)
        if not issubclass(data_class, genpy.Message):
            raise ValueError("data_class [%s] is not a message data class" % data_class.__class__.__name__)
        names.warn_if_illegal(name, stacklevel=3)
        if core.is_initialized():
            self.resolved_name = names.resolve_name(name)
        else:
            self.resolved_name = names.resolve_name_without_node_name(name)
        self.name = self.resolved_name
        self.data_class = data_class
        self.type = data_class._type
        self.md5sum = data_class._md5sum
        self.reg_type = reg_type
        with core.uninterrupted:
            self.impl = manager.acquire_impl(reg_type, self.resolved_name, data_class, options)

    def get_num_connections(self):
        """Number of connected peers."""
        return self.impl.get_num_connections()

    def unregister(self):
        """Release the topic; the last Publisher or Subscriber unregisters it."""
        if self.resolved_name and self.impl:
            with core.uninterrupted:
                manager.release_impl(self.reg_type, self.resolved_name)
            self.impl = self.resolved_name = self.type = self.md5sum = self.data_class = None


class Subscriber(Topic):
    """Call `callback(message)` or `callback(message, callback_args)` for each message."""

    def __init__(
        self,
        name,
        data_class,
        callback=None,
        callback_args=None,
        queue_size=None,
        buff_size=DEFAULT_BUFF_SIZE,
        tcp_nodelay=False,
    ):
        def options(impl):
            if queue_size is not None:
                impl.set_queue_size(queue_size)
            if buff_size != DEFAULT_BUFF_SIZE:
                impl.set_buff_size(buff_size)
            if tcp_nodelay:
                impl.tcp_nodelay = tcp_nodelay
            if callback is not None:
                impl.add_callback(callback, callback_args)

        self.callback = callback
        self.callback_args = None if callback is None else callback_args
        super().__init__(name, data_class, Registration.SUB, options)

    def unregister(self):
        """Release the topic; may be called in the callback."""
        if self.impl:
            if self.callback is not None:
                self.impl.remove_callback(self.callback, self.callback_args)
            self.callback = self.callback_args = None
            super().unregister()


class SubscribeListener:
    """Base class of listeners for subscribers that connect and disconnect."""

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """A subscriber connected; `topic_publish` sends a message to all, `peer_publish` only to it."""

    def peer_unsubscribe(self, topic_name, num_peers):
        """A subscriber disconnected; `num_peers` remain."""


class Publisher(Topic):
    """Publishes a topic."""

    def __init__(
        self,
        name,
        data_class,
        subscriber_listener=None,
        tcp_nodelay=False,
        latch=False,
        headers=None,
        queue_size=None,
    ):
        def options(impl):
            if subscriber_listener:
                impl.add_subscriber_listener(subscriber_listener)
            if latch:
                impl.enable_latch()
            if headers:
                impl.add_headers(headers)
            if queue_size is not None:
                impl.set_queue_size(queue_size)

        super().__init__(name, data_class, Registration.PUB, options)
        if queue_size is None:
            warnings.warn(
                "The publisher should be created with an explicit keyword argument 'queue_size'. "
                "Please see http://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers"
                " for more information.",
                SyntaxWarning,
                stacklevel=2,
            )

    def publish(self, *args, **kwds):
        """Send a message, given as a message or by its fields (positional or keyword).

        Raises:
            ROSException: `init_node` was not called, or this publisher is unregistered.
            ROSSerializationException: A value does not fit its field (detected only with a subscriber).
        """
        if self.impl is None:
            raise ROSException("publish() to an unregistered() handle")
        if not core.is_initialized():
            raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
        message = args_kwds_to_message(self.data_class, args, kwds)
        try:
            with core.uninterrupted:
                self.impl.publish(message)
        except genpy.SerializationError as error:
            core.logger.error(traceback.format_exc())
            raise ROSSerializationException(str(error)) from error
