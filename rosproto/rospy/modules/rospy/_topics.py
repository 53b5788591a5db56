"""The published and the subscribed topics of this process; the Publisher or Subscriber objects of a topic
share one.

A published topic is one registration, its queue, its latched message, its listeners; a subscribed one is
one subscription, and the callbacks of all its Subscriber objects.
"""

import sys
import threading
import time
import traceback
from types import SimpleNamespace

import genpy
from genpy.message import encode_message

from rosproto.errors import CodecError, LocalProtocolError, RosError, RosTimeout
from rosproto.node.events import is_interrupt
from rosproto.rospy.messages import node_class

from . import core
from .exceptions import ROSException
from .impl import statistics
from .impl.tcpros_base import DEFAULT_BUFF_SIZE
from .msg import AnyMsg

SETTLE = 0.02
"""Seconds after the registration in which no callback comes: rospy's links take longer, and programs use what
`self.sub = rospy.Subscriber(...)` assigns in the callback."""
MAX_ATTACHING = 1.0  # seconds
UNBOUNDED = sys.maxsize  # messages that may wait; rospy has no bound by default


def _connection(endpoint_id, callerid):
    """A peer, with the attributes that programs use: its node name, and its name or (of a publisher) URI."""
    return SimpleNamespace(endpoint_id=endpoint_id, callerid_pub=callerid, callerid=callerid, done=False)


class TopicImpl:
    """One topic of this process, in one direction.

    Attributes:
        handle: The node's Publisher or Subscriber; None before there is a node.
        refused: The master refused the registration; nothing is sent or received.
    """

    def __init__(self, name, data_class):
        self.resolved_name = self.name = name
        self.data_class = data_class
        self.type = data_class._type
        self.ref_count = 0
        self.closed = self.refused = False
        self.handle = None
        self.c_lock = threading.RLock()
        self._settled = False
        self._attached = threading.Event()
        self._settles_at = 0.0

    def attached(self):
        """Note that the node has opened the topic, and the constructor returns."""
        self._settles_at = time.monotonic() + SETTLE
        self._attached.set()

    def settle(self):
        """Delay the first callback, in a library thread, until the program has had time to continue."""
        if self._attached.wait(MAX_ATTACHING):
            time.sleep(max(0.0, self._settles_at - time.monotonic()))
        self._settled = True

    @property
    def connections(self):
        """The peers connected now."""
        return [] if self.handle is None or self.closed else self._connections()

    def get_num_connections(self):
        """The number of peers connected now."""
        return 0 if self.handle is None or self.closed else self.handle.connections

    def has_connection(self, endpoint_id):
        """True when this peer is connected."""
        return any(connection.endpoint_id == endpoint_id for connection in self.connections)

    def has_connections(self):
        """True when any peer is connected."""
        return self.get_num_connections() > 0

    def close(self):
        """Close the topic."""
        self.closed = True
        if self.handle is not None:
            self.handle.close()


class PublisherImpl(TopicImpl):
    KIND = "publication"

    def __init__(self, name, data_class):
        super().__init__(name, data_class)
        self.seq = 0
        self.is_latch = False
        self.latch = None
        self.queue_size = None
        self.headers = {}
        self.subscriber_listeners = []
        self.publock = threading.RLock()
        self._class = node_class(data_class)

    def attach(self, node):
        """Publish."""
        self.handle = node.publisher(
            self.resolved_name,
            self._class,
            latch=self.is_latch,
            queue_size=_queue_limit(self.queue_size),
            on_connect=self._connected,
            on_disconnect=self._left,
            header=self._fields,
        )
        self.attached()

    def _fields(self):
        return {str(key): str(value) for key, value in self.headers.items()}

    def _connections(self):
        return [_connection(name, name) for name in self.handle.subscribers]

    def add_subscriber_listener(self, listener):
        """Add a listener."""
        self.subscriber_listeners.append(listener)

    def add_headers(self, headers):
        """Add header fields for subscribers that connect from now on; standard fields keep their values."""
        self.headers.update(headers)

    def enable_latch(self):
        """Give late subscribers the last message."""
        self.is_latch = True
        if self.handle is not None:
            self.handle.latch = True

    def set_queue_size(self, queue_size):
        """Set how many messages may wait for a slow subscriber; 0 for any number."""
        self.queue_size = queue_size
        if self.handle is not None:
            self.handle.queue_size = _queue_limit(queue_size)

    def close(self):
        """Close the topic; drops the latched message and the listeners."""
        super().close()
        self.latch = None
        self.subscriber_listeners = []

    def acquire(self):
        """Keep other threads from publishing."""
        self.publock.acquire()

    def release(self):
        """Let other threads publish again."""
        self.publock.release()

    def _connected(self, caller_id):
        self.settle()
        for listener in list(self.subscriber_listeners):
            listener.peer_subscribe(
                self.resolved_name, self.publish, lambda message: self._publish_to(caller_id, message)
            )

    def _left(self, caller_id):
        for listener in list(self.subscriber_listeners):
            listener.peer_unsubscribe(self.resolved_name, self.get_num_connections())

    def _publish_to(self, caller_id, message):
        self._stamp(message)
        self.handle.publish_to(caller_id, encode_message(message))

    def publish(self, message):
        """Send a message to all subscribers."""
        if core.is_shutdown() or self.refused:
            return
        if self.closed or self.handle is None:
            raise ROSException("publish() to a closed topic")
        with self.publock:
            if not self.handle.connections:
                if self.is_latch:
                    self._keep(message)
                return
            self._stamp(message)
            self._send(message)

    def _keep(self, message):
        """Latch a message without subscribers; one with wrong values is ignored."""
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
            self.handle.publish(encode_message(message) if isinstance(message, AnyMsg) else message)
        except CodecError:
            self.handle.publish(encode_message(message))  # encoded by genpy's rules, or its error raised
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


def _queue_limit(queue_size):
    """The size of the queue; rospy accepts any value, and only a number above 0 is a bound."""
    return queue_size if isinstance(queue_size, int) and queue_size > 0 else UNBOUNDED


class SubscriberImpl(TopicImpl):
    KIND = "subscription"

    def __init__(self, name, data_class):
        super().__init__(name, data_class)
        self.callbacks = []
        self.queue_size = None
        self.buff_size = DEFAULT_BUFF_SIZE
        self.tcp_nodelay = False
        self._latched = {}
        self._statistics = None

    def attach(self, node):
        """Subscribe."""
        anything = issubclass(self.data_class, AnyMsg)
        self._statistics = statistics.of_subscriber(self)
        self.handle = node.subscriber(
            self.resolved_name,
            None if anything else node_class(self.data_class),
            self._receive_raw if anything else self._receive,
            queue_size=self.queue_size or UNBOUNDED,
            raw=anything,
            tcp_nodelay=self.tcp_nodelay,
            inline=True,
        )
        self.attached()

    def close(self):
        """Close the topic."""
        super().close()
        if self._statistics is not None:
            self._statistics.close()

    def _connections(self):
        return [_connection(uri, caller_id) for uri, caller_id in self.handle.publisher_uris.items()]

    def set_queue_size(self, queue_size):
        """Set how many messages of one read are delivered, the latest ones; None for all."""
        if queue_size == -1:
            queue_size = None
        elif queue_size == 0:
            raise ROSException("queue size may not be set to zero")
        elif queue_size is not None and type(queue_size) is not int:
            raise ROSException("queue size must be an integer")
        self.queue_size = queue_size
        if self.handle is not None:
            self.handle.queue_size = queue_size or UNBOUNDED

    def set_buff_size(self, buff_size):
        """Check and keep the size. It has no effect: messages of any size are received whole."""
        if type(buff_size) is not int:
            raise ROSException("buffer size must be an integer")
        if buff_size <= 0:
            raise ROSException("buffer size must be a positive integer")
        self.buff_size = buff_size

    def set_tcp_nodelay(self, tcp_nodelay):
        """Ask publishers connected from now on to send at once."""
        self.tcp_nodelay = tcp_nodelay
        if self.handle is not None:
            self.handle.tcp_nodelay = tcp_nodelay

    def add_callback(self, cb, cb_args):
        """Add a callback; it is called with the latched messages received before."""
        if self.closed:
            raise ROSException("subscriber [%s] has been closed" % self.resolved_name)
        with self.c_lock:
            self.callbacks = [*self.callbacks, (cb, cb_args)]
            latched = list(self._latched.values())
        for message in latched:
            self._invoke(message, cb, cb_args)

    def remove_callback(self, cb, cb_args):
        """Remove a callback.

        Raises:
            KeyError: It was not added.
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
        if not self._settled:
            self.settle()
        header = message._connection_header or {}
        if header.get("latching") == "1":
            self._remember(header.get("callerid"), message)
        if core.is_shutdown():
            return
        if self._statistics is not None:
            self._statistics.note(message)
        for cb, cb_args in self.callbacks:
            self._invoke(message, cb, cb_args)

    def _remember(self, caller_id, message):
        """Keep a latched message for later callbacks, until its publisher has gone and another one comes."""
        if caller_id not in self._latched and self.handle is not None:
            present = {*self.handle.publisher_uris.values(), caller_id}
            self._latched = {who: kept for who, kept in list(self._latched.items()) if who in present}
        self._latched[caller_id] = message

    def _invoke(self, message, cb, cb_args):
        try:
            if cb_args is None:
                cb(message)
            else:
                cb(message, cb_args)
        except SystemExit:
            pass  # in rospy it ends a receiving thread, not the program
        except BaseException as error:
            if is_interrupt(error):
                raise
            if core.is_shutdown():
                core.logger.warning("during shutdown, bad callback: %s\n%s", cb, traceback.format_exc())
            else:
                core.logerr("bad callback: %s\n%s" % (cb, traceback.format_exc()))
