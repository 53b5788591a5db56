"""`Subscriber`, the public API for receiving a topic."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rosproto.coercion import as_float
from rosproto.errors import ConnectionLost, LocalProtocolError, RosTimeout
from rosproto.node.context import Context
from rosproto.node.incoming.subscriber_queue import SubscriberQueue
from rosproto.node.incoming.subscription import Subscription
from rosproto.node.stats import LinkStats
from rosproto.sentence import say


class Subscriber:
    """Receives one topic; made by `Node.subscriber`. Close it, or use it in a `with` block.

    Read messages by iteration, `next` or `latest`, or give a `callback`. At most `queue_size` messages wait
    for the program; the oldest is dropped and counted. With `queue_size=1` only the newest waits.

    The callback runs in a thread of the library, one call at a time for each subscriber: a quick one in the
    thread that received the message, a slow one (2 ms) in a separate thread, so that other subscribers are
    not delayed. Its exceptions are logged. Subscribers of one topic in a node get the same message objects:
    do not change them.

    Attributes:
        raw: Messages are `rosproto.AnyMsg` with the encoded bytes, not decoded.
        type: The requested type.
    """

    def __init__(
        self,
        context: Context,
        subscription: Subscription,
        queue: SubscriberQueue,
        on_close: Callable[[], None],
    ) -> None:
        self._context = context
        self._subscription = subscription
        self._queue = queue
        self._on_close = on_close
        self.type = queue.type
        self.raw = queue.raw
        self._inbox = queue.inbox

    # -- messages -------------------------------------------------------------------------------------------

    def next(self, timeout: float | None = 10.0) -> Any:
        """Wait for the next message: the oldest one not taken yet.

        Args:
            timeout: Seconds; None waits for ever.

        Raises:
            RosTimeout: No message came; the text has the state of each publisher.
            ConnectionLost: The subscriber or the node was closed meanwhile.
        """
        return self.next_stamped(timeout)[0]

    def next_stamped(self, timeout: float | None = 10.0) -> tuple[Any, float]:
        """As `next`, with the time of receipt: seconds since 1970 by this computer's clock."""
        self._check_no_callback()
        timeout = as_float(timeout)
        item = self._inbox.get(timeout)
        if item is not None:
            return item
        if self._inbox.closed:
            raise ConnectionLost(say("{topic}: this subscriber is closed", topic=self.topic))
        raise RosTimeout(
            f"{self.topic}: no message within {timeout:g} s; {self._subscription.why_silent()}"
            f" (master {self._context.master.uri})",
            what=f"a message on {self.topic}",
            seconds=timeout,
        )

    def __iter__(self) -> Iterator[Any]:
        """Every message from now on, until the subscriber or the node is closed."""
        self._check_no_callback()
        while True:
            item = self._inbox.get(None)
            if item is None:
                return
            yield item[0]

    def _check_no_callback(self) -> None:
        if self._queue.runner is not None:
            text = "{topic}: this subscriber has a callback, which gets every message"
            raise LocalProtocolError(say(text, topic=self.topic))

    @property
    def latest(self) -> Any:
        """The newest message received, None before the first. Reading it does not change the queue."""
        return self._inbox.latest

    # -- state ----------------------------------------------------------------------------------------------

    @property
    def topic(self) -> str:
        """Resolved name."""
        return self._subscription.name

    @property
    def type_name(self) -> str:
        """ "package/Type"; "*" if no type was given and no publisher has connected yet."""
        return self._subscription.present_type.name

    @property
    def md5sum(self) -> str:
        """md5sum of the type, or "*"."""
        return self._subscription.present_type.md5sum

    @property
    def message_class(self) -> type:
        """Class of the messages."""
        return self._subscription.present_type.message_class

    @property
    def connections(self) -> int:
        """Publishers connected now."""
        return self._subscription.connections

    @property
    def queue_size(self) -> int:
        """Maximum number of messages that wait for the program; may be changed."""
        return self._queue.queue_size

    @queue_size.setter
    def queue_size(self, size: int) -> None:
        self._queue.queue_size = size

    @property
    def tcp_nodelay(self) -> bool:
        """True to request TCP_NODELAY from publishers connected from now on; see `Node.subscriber`."""
        return self._subscription.tcp_nodelay

    @tcp_nodelay.setter
    def tcp_nodelay(self, ask: bool) -> None:
        self._subscription.tcp_nodelay = ask

    @property
    def publisher_uris(self) -> dict[str, str]:
        """XML-RPC URI of each publisher connected now, with its node's name."""
        links = list(self._subscription.links.values())
        return {link.uri: link.caller_id for link in links if link.connected}

    @property
    def publishers(self) -> list[str]:
        """Caller ids of the publishers connected now."""
        return [link.caller_id for link in list(self._subscription.links.values()) if link.connected]

    @property
    def latching(self) -> bool:
        """True when a connected publisher latches: its last message comes right after connecting."""
        return any(link.header.get("latching") == "1" for link in list(self._subscription.links.values()))

    @property
    def errors(self) -> list[Exception]:
        """The last errors of this topic's links, the newest last: lost links, refused handshakes, messages of
        another revision that did not fit."""
        return list(self._subscription.errors)

    @property
    def unfit(self) -> int:
        """Messages of another revision, dropped because a value does not fit ours."""
        return self._subscription.unfit

    @property
    def received(self) -> int:
        """Messages received for this subscriber."""
        return self._inbox.received

    @property
    def dropped(self) -> int:
        """Messages dropped because more than `queue_size` waited."""
        return self._inbox.dropped + self._subscription.skipped_so_far

    @property
    def closed(self) -> bool:
        """True after `close`, or when the node is closed."""
        return self._inbox.closed

    @property
    def keeps(self) -> int | None:
        """Most messages of one read that are delivered; None for all (to a quick callback)."""
        return self._queue.keeps

    def wait_for_connection(self, timeout: float | None = 5.0, count: int = 1) -> None:
        """Wait until `count` publishers are connected; `timeout` in seconds, None waits for ever.

        Raises:
            RosTimeout: Fewer were in time; the text has the state of each publisher.
        """
        timeout = as_float(timeout)
        if not self._subscription.wait_for(count, timeout):
            raise RosTimeout(
                f"{self.topic}: {self.connections} of {count} publishers connected after {timeout:g} s;"
                f" {self._subscription.why_silent()} (master {self._context.master.uri})",
                what=f"publishers of {self.topic}",
                seconds=timeout,
            )

    def why_silent(self) -> str:
        """The state of each publisher that the master names, as text, to explain missing messages."""
        return self._subscription.why_silent()

    def stats(self) -> Sequence[LinkStats]:
        """Counters per publisher (shared by all subscribers of the topic in this node)."""
        return self._subscription.stats()

    def close(self) -> None:
        """Stop receiving: iteration ends, no callback begins. May be called twice, and in the callback."""
        if not self._inbox.closed:
            self._queue.end()
            self._on_close()

    def __enter__(self) -> Subscriber:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self.closed else f"{self.connections} publishers"
        return f"<Subscriber {self.topic} {self.type_name}, {state}>"
