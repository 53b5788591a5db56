"""A published topic of this process: one registration, its queue, its latched message, its listeners."""

import threading

import genpy

from rosproto.codec import encoder
from rosproto.errors import CodecError, LocalProtocolError, RosError, RosTimeout
from rosproto.rospy.messages import is_ours, node_class

from . import core
from ._topic_impl import UNBOUNDED, Connection, TopicImpl
from .exceptions import ROSException
from .msg import AnyMsg


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
        self._peers = set()

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

    @property
    def connections(self):
        """The subscribers connected now."""
        if self.handle is None or self.closed:
            return []
        return [Connection(name, name) for name in self.handle.subscribers]

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
        self.handle.publish_to(caller_id, self._bytes(message))

    def publish(self, message):
        """Send a message to all subscribers."""
        if self.closed or self.handle is None:
            if core.is_shutdown() or self.refused:
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
        """Latch a message that nobody receives yet; one with wrong values is ignored."""
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
        except CodecError:
            self.handle.publish(self._bytes(message))  # encoded by genpy's rules, or its error raised
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
        if is_ours(type(message)):
            from genpy.message import encode_message

            return encode_message(message)
        return encoder(node_class(type(message)))(message)


def _queue_limit(queue_size):
    """The size of the queue; rospy accepts any value, and only a number above 0 is a bound."""
    return queue_size if isinstance(queue_size, int) and queue_size > 0 else UNBOUNDED
