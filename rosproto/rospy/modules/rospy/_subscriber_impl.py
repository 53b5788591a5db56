"""A subscribed topic of this process: one subscription, and the callbacks of all its Subscriber objects."""

import traceback

from rosproto.node.events import is_interrupt
from rosproto.rospy.messages import node_class

from . import core
from ._topic_impl import UNBOUNDED, Connection, TopicImpl
from .exceptions import ROSException
from .impl import statistics
from .impl.tcpros_base import DEFAULT_BUFF_SIZE
from .msg import AnyMsg


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

    @property
    def connections(self):
        """The publishers connected now."""
        if self.handle is None or self.closed:
            return []
        return [Connection(uri, caller_id) for uri, caller_id in self.handle.publisher_uris.items()]

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
        """For callbacks that come later; of publishers that have gone when another one comes, no more."""
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
