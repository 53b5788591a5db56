"""rospy.topics: Publisher and Subscriber.

All publishers of a topic in this process share one implementation, as do all subscribers: one registration,
one connection per peer, callbacks one after the other in the thread that receives. They may be made before
init_node; the implementation is attached to the node when there is one.
"""

import sys
import threading
import traceback

import genpy
import rosgraph.names

from rosproto.errors import CodecError, LocalProtocolError, RosError, RosTimeout
from rosproto.rospy.messages import carried, is_known

from . import core, names
from .exceptions import ROSException, ROSSerializationException
from .impl.registration import Registration
from .impl.tcpros_base import DEFAULT_BUFF_SIZE
from .msg import AnyMsg, args_kwds_to_message

__all__ = ["Message", "Publisher", "SubscribeListener", "Subscriber", "Topic"]

Message = genpy.Message
UNBOUNDED = sys.maxsize  # messages that may wait; rospy has no bound by default


class Topic:
    """What Publisher and Subscriber have in common."""

    def __init__(self, name, data_class, reg_type, options):
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        if data_class is None:
            raise ValueError("topic parameter 'data_class' is not initialized")
        if not isinstance(data_class, type):
            raise ValueError("data_class [%s] is not a class" % data_class)
        if not issubclass(data_class, genpy.Message):
            raise ValueError("data_class [%s] is not a message data class" % data_class.__class__.__name__)
        if not rosgraph.names.is_legal_name(name):
            import warnings

            warnings.warn(
                "'%s' is not a legal ROS graph resource name. This may cause problems with other ROS tools"
                % name,
                stacklevel=3,
            )
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
        """Peers connected now."""
        return self.impl.get_num_connections()

    def unregister(self):
        """Give the topic up; the last one of it takes it off the master."""
        if self.resolved_name and self.impl:
            with core.uninterrupted:
                manager.release_impl(self.reg_type, self.resolved_name)
            self.impl = self.resolved_name = self.type = self.md5sum = self.data_class = None


class _Connection:
    """A peer, as programs look at it.

    Attributes:
        endpoint_id: Its node name for a subscriber of ours, its URI for a publisher.
        callerid_pub: Its node name.
    """

    def __init__(self, endpoint_id, callerid):
        self.endpoint_id = endpoint_id
        self.callerid_pub = self.callerid = callerid
        self.done = False


class _TopicImpl:
    """One topic of this process, in one direction.

    Attributes:
        handle: The node's Publisher or Subscriber; None before there is a node.
    """

    def __init__(self, name, data_class):
        self.resolved_name = self.name = name
        self.data_class = data_class
        self.type = data_class._type
        self.ref_count = 0
        self.closed = False
        self.handle = None
        self.c_lock = threading.RLock()

    @property
    def connections(self):
        """The peers connected now."""
        return []

    def get_num_connections(self):
        """How many they are."""
        return 0 if self.handle is None or self.closed else self.handle.connections

    def has_connection(self, endpoint_id):
        """True when that one is connected."""
        return any(connection.endpoint_id == endpoint_id for connection in self.connections)

    def has_connections(self):
        """True when any is."""
        return self.get_num_connections() > 0

    def close(self):
        """End it."""
        self.closed = True
        if self.handle is not None:
            self.handle.close()


# -- subscriber ---------------------------------------------------------------------------------------------


class Subscriber(Topic):
    """Has `callback(message)`, or `callback(message, callback_args)`, called with each message."""

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
        """Give the topic up; may be called in the callback."""
        if self.impl:
            if self.callback is not None:
                self.impl.remove_callback(self.callback, self.callback_args)
            self.callback = self.callback_args = None
            super().unregister()


class _SubscriberImpl(_TopicImpl):
    def __init__(self, name, data_class):
        super().__init__(name, data_class)
        self.callbacks = []
        self.queue_size = None
        self.buff_size = DEFAULT_BUFF_SIZE
        self.tcp_nodelay = False
        self._latched = {}

    def attach(self, node):
        """Subscribe."""
        anything = issubclass(self.data_class, AnyMsg)
        self.handle = node.subscriber(
            self.resolved_name,
            None if anything else carried(self.data_class),
            self._receive_raw if anything else self._receive,
            queue_size=self.queue_size or UNBOUNDED,
            raw=anything,
            tcp_nodelay=self.tcp_nodelay,
            inline=True,
        )

    @property
    def connections(self):
        """The publishers connected now."""
        if self.handle is None or self.closed:
            return []
        links = list(self.handle._subscription.links.values())
        return [_Connection(link.uri, link.caller_id) for link in links if link.connected]

    def set_queue_size(self, queue_size):
        """Of what one read brings, the last so many messages are called with; None for all."""
        if queue_size == -1:
            queue_size = None
        elif queue_size == 0:
            raise ROSException("queue size may not be set to zero")
        elif queue_size is not None and type(queue_size) is not int:
            raise ROSException("queue size must be an integer")
        self.queue_size = queue_size
        if self.handle is not None:
            self.handle.queue_size = self.handle._inbox.size = queue_size or UNBOUNDED
            self.handle._subscription._renew_sink()

    def set_buff_size(self, buff_size):
        """Checked, not needed: messages of any size are received whole."""
        if type(buff_size) is not int:
            raise ROSException("buffer size must be an integer")
        if buff_size <= 0:
            raise ROSException("buffer size must be a positive integer")
        self.buff_size = buff_size

    def set_tcp_nodelay(self, tcp_nodelay):
        """Ask publishers connected from now on to send at once."""
        self.tcp_nodelay = tcp_nodelay
        if self.handle is not None:
            self.handle._subscription.tcp_nodelay = tcp_nodelay

    def add_callback(self, cb, cb_args):
        """One more; it gets the latched messages that came before it."""
        if self.closed:
            raise ROSException("subscriber [%s] has been closed" % self.resolved_name)
        with self.c_lock:
            self.callbacks = [*self.callbacks, (cb, cb_args)]
            latched = list(self._latched.values())
        for message in latched:
            self._invoke(message, cb, cb_args)

    def remove_callback(self, cb, cb_args):
        """Take one away.

        Raises:
            KeyError: It is not there.
        """
        if self.closed:
            return
        with self.c_lock:
            callbacks = list(self.callbacks)
            found = next((i for i, pair in enumerate(callbacks) if pair == (cb, cb_args)), None)
            if found is None:
                raise KeyError("no matching cb")
            del callbacks[found]
            self.callbacks = callbacks

    def _receive_raw(self, raw):
        message = AnyMsg()
        message._buff = raw._buff
        message._connection_header = raw._connection_header
        self._receive(message)

    def _receive(self, message):
        header = message._connection_header or {}
        if header.get("latching") == "1":
            self._latched[header.get("callerid")] = message
        if core.is_shutdown():
            return
        for cb, cb_args in self.callbacks:
            self._invoke(message, cb, cb_args)

    def _invoke(self, message, cb, cb_args):
        try:
            if cb_args is None:
                cb(message)
            else:
                cb(message, cb_args)
        except SystemExit:
            pass  # ends a thread of rospy's, not the program
        except BaseException:
            if core.is_shutdown():
                core._logger.warning("during shutdown, bad callback: %s\n%s", cb, traceback.format_exc())
            else:
                core.logerr("bad callback: %s\n%s" % (cb, traceback.format_exc()))


# -- publisher ----------------------------------------------------------------------------------------------


class SubscribeListener:
    """Told when subscribers come and go; derive from it."""

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        """One came: `topic_publish(message)` sends to all, `peer_publish(message)` to this one."""

    def peer_unsubscribe(self, topic_name, num_peers):
        """One went; so many are left."""


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
            if queue_size is not None:
                impl.set_queue_size(queue_size)

        super().__init__(name, data_class, Registration.PUB, options)
        if queue_size is None:
            import warnings

            warnings.warn(
                "The publisher should be created with an explicit keyword argument 'queue_size'. "
                "Please see http://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers"
                " for more information.",
                SyntaxWarning,
                stacklevel=2,
            )

    def publish(self, *args, **kwds):
        """Send a message: itself, its fields by position, or by keyword.

        Raises:
            ROSException: There is no node, or this publisher is unregistered.
            ROSSerializationException: A value does not fit its field (noticed only with a subscriber).
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
            core._logger.error(traceback.format_exc())
            raise ROSSerializationException(str(error)) from error


class _PublisherImpl(_TopicImpl):
    def __init__(self, name, data_class):
        super().__init__(name, data_class)
        self.seq = 0
        self.is_latch = False
        self.latch = None
        self.queue_size = None
        self.subscriber_listeners = []
        self.publock = threading.RLock()
        self._class = carried(data_class)
        self._peers = set()

    def attach(self, node):
        """Publish."""
        from rosproto.node.topic_types import resolve_type

        # Below `Node.publisher`, which refuses the wildcard; rospy publishes AnyMsg.
        self.handle = node._topics.open_publisher(
            self.resolved_name,
            resolve_type(self._class),
            latch=self.is_latch,
            queue_size=self.queue_size or UNBOUNDED,
            on_connect=self._connected,
        )
        node.on_topic_left(self.resolved_name, self._left)

    @property
    def connections(self):
        """The subscribers connected now."""
        if self.handle is None or self.closed:
            return []
        return [_Connection(name, name) for name in self.handle.subscribers]

    def add_subscriber_listener(self, listener):
        """Tell this one too."""
        self.subscriber_listeners.append(listener)

    def enable_latch(self):
        """Give late subscribers the last message."""
        self.is_latch = True
        if self.handle is not None:
            self.handle.latch = True

    def set_queue_size(self, queue_size):
        """So many messages may wait for a slow subscriber; 0 for any number."""
        self.queue_size = queue_size
        if self.handle is not None:
            self.handle.queue_size = queue_size or UNBOUNDED

    def acquire(self):
        """Keep other threads from publishing."""
        self.publock.acquire()

    def release(self):
        """Let them again."""
        self.publock.release()

    def _connected(self, caller_id):
        link = next((one for one in self.handle._publication.links[::-1] if one.caller_id == caller_id), None)
        for listener in list(self.subscriber_listeners):
            listener.peer_subscribe(
                self.resolved_name, self.publish, lambda message: self._publish_to(link, message)
            )

    def _left(self):
        for listener in list(self.subscriber_listeners):
            listener.peer_unsubscribe(self.resolved_name, self.get_num_connections())

    def _publish_to(self, link, message):
        from rosproto.node.frames import small_frame

        if link is not None:
            self._stamp(message)
            link.send(small_frame(self._bytes(message)))

    def publish(self, message):
        """Send to all."""
        if self.closed or self.handle is None:
            if core.is_shutdown():
                return
            raise ROSException("publish() to a closed topic")
        if core.is_shutdown():
            return
        with self.publock:
            if not self.handle.connections:
                if self.is_latch:
                    self._keep(message)
                return
            self._stamp(message)
            self._send(message)

    def _keep(self, message):
        """Nobody is there to get it: wrong values are not noticed, and not kept."""
        self.latch = message
        try:
            self._send(message)
        except (genpy.SerializationError, AttributeError, TypeError):
            pass

    def _stamp(self, message):
        if getattr(message.__class__, "_has_header", False):
            self.seq += 1
            message.header.seq = self.seq
            if message.header.frame_id is None:
                message.header.frame_id = "0"

    def _send(self, message):
        try:
            if isinstance(message, AnyMsg):
                self.handle.publish(self._bytes(message))
            else:
                self.handle.publish(message)
        except CodecError as error:
            from genpy.message import refuse

            refuse(message, error)
        except LocalProtocolError:
            if not core.is_shutdown():
                raise ROSException("publish() to a closed topic") from None
        if self.queue_size is None:
            self._wait_sent()

    def _wait_sent(self):
        """Without a queue size, publish() waits for slow subscribers."""
        while not core.is_shutdown() and not self.closed:
            try:
                self.handle.flush(0.5)
                return
            except RosTimeout:
                pass
            except RosError:
                return

    @staticmethod
    def _bytes(message):
        if isinstance(message, AnyMsg):
            if message._buff is None:
                raise ROSException("AnyMsg is not initialized")
            return bytes(message._buff)
        if is_known(type(message)):
            from genpy.message import encode_message

            return encode_message(message)
        return carried(type(message))._encode(message)


# -- the table ----------------------------------------------------------------------------------------------


class _TopicManager:
    """The topics of this process."""

    def __init__(self):
        self.pubs = {}
        self.subs = {}
        self.lock = threading.RLock()
        self._node = None

    def attach(self, node):
        """There is a node: open what was made before."""
        with self.lock:
            self._node = node
            for impl in [*self.pubs.values(), *self.subs.values()]:
                impl.attach(node)

    def _table(self, reg_type):
        return self.pubs if reg_type == Registration.PUB else self.subs

    def acquire_impl(self, reg_type, resolved_name, data_class, options):
        """The implementation of a topic, made when it is the first use; `options(impl)` sets it up."""
        with self.lock:
            table = self._table(reg_type)
            impl = table.get(resolved_name)
            if impl is None:
                kind = _PublisherImpl if reg_type == Registration.PUB else _SubscriberImpl
                impl = kind(resolved_name, data_class)
                options(impl)
                if self._node is not None:
                    self._open(impl)
                table[resolved_name] = impl
            else:
                options(impl)
            impl.ref_count += 1
            return impl

    def _open(self, impl):
        try:
            impl.attach(self._node)
        except (RosError, OSError) as error:
            if not core.is_shutdown():
                raise ROSException("cannot register [%s]: %s" % (impl.resolved_name, error)) from error

    def release_impl(self, reg_type, resolved_name):
        """One use less; the last one closes it."""
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


manager = _TopicManager()
