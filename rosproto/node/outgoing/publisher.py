"""Publisher: the program's handle to publish a topic."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rosproto.codec import Message
from rosproto.coercion import as_float
from rosproto.errors import LocalProtocolError, RosError, RosTimeout
from rosproto.node.context import Context
from rosproto.node.outgoing.publication import Publication
from rosproto.node.stats import LinkStats
from rosproto.sentence import led, say
from rosproto.transport.os_errors import translate


class Publisher:
    """Publishes one topic; made by `Node.publisher`. Close it, or use it in a `with` block.

    Attributes:
        latch: Whether later subscribers get the last message published here.
        queue_size: Queue length per subscriber; when full, the oldest message is dropped and counted.
        on_connect: Called with the caller id of each new subscriber, in a thread of the library.
        on_disconnect: The same for each subscriber that has disconnected.
        header: Returns additional fields of the connection header for new subscribers; or None.
        linger: Whether the system still delivers sent messages after the program is killed.
    """

    def __init__(
        self,
        context: Context,
        on_close: Callable[[Publisher, Publication, float], None],
        publication: Publication,
        *,
        latch: bool,
        queue_size: int,
        on_connect: Callable[[str], object] | None,
        on_disconnect: Callable[[str], object] | None,
        header: Callable[[], Mapping[str, str]] | None,
        linger: bool,
    ) -> None:
        self._context = context
        self._publication = publication
        self._on_close = on_close
        self.latch = latch
        self.queue_size = queue_size
        self.on_connect = on_connect
        self.on_disconnect = on_disconnect
        self.header = header
        self.linger = linger
        self._closed = False

    @property
    def topic(self) -> str:
        """Resolved name."""
        return self._publication.name

    @property
    def type_name(self) -> str:
        """ "package/Type"."""
        return self._publication.type.name

    @property
    def md5sum(self) -> str:
        """md5sum of the type."""
        return self._publication.type.md5sum

    @property
    def message_class(self) -> type[Message]:
        """Class of the messages."""
        return self._publication.type.message_class

    @property
    def connections(self) -> int:
        """Subscribers connected now."""
        return len(self._publication.all_links)

    @property
    def closed(self) -> bool:
        """True after `close`, or when the node is closed."""
        return self._closed

    @property
    def subscribers(self) -> list[str]:
        """Caller ids of the subscribers connected now."""
        return [link.caller_id for link in self._publication.all_links]

    @property
    def revisions(self) -> dict[str, type[Message]]:
        """Class that each connected subscriber decodes, by caller id: `message_class` or a revision of it."""
        return {link.caller_id: cls for link, cls in self._publication.wanted}

    def publish(self, message: object = None, **fields: object) -> None:
        """Send a message to all subscribers; never waits for a slow subscriber.

        The message is encoded before this returns, so later changes to it do not affect the bytes sent. The
        message itself is not modified: `header.seq` is written into the bytes only. Without subscribers (and
        unless latched) the message is not encoded, so invalid values are not detected.

        If a subscriber's connection is full, up to `queue_size` messages are queued; then the oldest is
        dropped (counted in `stats()`).

        Args:
            message: A message of the type, or its encoded bytes (`bytes`, or an `AnyMsg` of a raw
                subscription), which are relayed as they are.
            **fields: Instead of `message`, fields of a new one.

        Raises:
            CodecError: A value does not fit its field, or the message is of another type.
            LocalProtocolError: This publisher is closed.
        """
        if self._closed:
            raise LocalProtocolError(led(self.topic, "this publisher is closed; create another to publish"))
        try:
            if message is None or fields:
                message = self._message_of(message, fields)
            self._publication.publish(self, message)
        except OSError as error:  # the first message imports its encoder: too many open files
            if isinstance(error, RosError):
                raise
            raise translate(error, say("publish {topic}", topic=self.topic), "") from error

    def publish_to(self, caller_id: str, data: bytes) -> bool:
        """Send a message to one subscriber only: the newest connection of that node.

        Args:
            caller_id: Name of the subscriber's node, as passed to `on_connect`.
            data: The encoded message.

        Returns:
            False when no such subscriber is connected.
        """
        return self._publication.send_to(caller_id, data)

    def _message_of(self, message: object, fields: Mapping[str, object]) -> Message:
        if message is not None:
            raise TypeError("publish() takes a message or fields, not both")
        return self.message_class(**fields)

    def wait_for_connection(self, timeout: float | None = 5.0, count: int = 1) -> None:
        """Wait for subscribers; messages published earlier are lost unless latched.

        Args:
            timeout: Seconds; None waits for ever.
            count: Number of subscribers.

        Raises:
            RosTimeout: Fewer subscribers connected in time; the text gives details.
        """
        timeout = as_float(timeout)
        if self._publication.wait_for(count, timeout):
            return
        if self._closed:
            raise LocalProtocolError(f"{self.topic}: this publisher was closed while waiting for subscribers")
        raise RosTimeout(
            f"{self.topic}: {self.connections} of {count} subscribers connected after {timeout:g} s"
            f"{self._context.events.last_refusal(self.topic)}; check that somebody subscribes to exactly this"
            f" topic at the master {self._context.master.uri} and can reach {self._context.uri}",
            what=f"subscribers of {self.topic}",
            seconds=timeout,
        )

    def flush(self, timeout: float = 5.0) -> None:
        """Wait until the operating system has accepted every message published so far.

        Raises:
            RosTimeout: A subscriber is too slow.
        """
        self._publication.flush(timeout)

    def wait_arrived(self, timeout: float = 5.0) -> bool | None:
        """Wait until the subscribers' computers have received everything published so far.

        `flush` only waits for this computer; a network that loses packets may deliver much later, or never.

        Returns:
            True if everything arrived (disconnected subscribers are ignored); False after `timeout` seconds;
            None, at once, where this is not known: on Windows and macOS, and over UDPROS.
        """
        return self._publication.wait_arrived(timeout)

    def stats(self) -> Sequence[LinkStats]:
        """Counters per connected subscriber (shared by all publishers of the topic in this node)."""
        return self._publication.stats()

    def end(self) -> None:
        """As `close`, while the node closes: the topic is already unregistered."""
        self._closed = True

    def close(self, wait: float = 0.0) -> None:
        """Stop publishing; the last publisher of the topic unregisters it. May be called twice.

        Args:
            wait: Seconds at most to wait, before the topic is unregistered, until the subscribers have read
                everything. Told by the master that the publisher is gone, a subscriber (also rospy, roscpp)
                disconnects at once; what it has received but not read is lost.
        """
        if not self._closed:
            self._closed = True
            self._on_close(self, self._publication, wait)

    def __enter__(self) -> Publisher:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{self.connections} subscribers"
        return f"<Publisher {self.topic} {self.type_name}, {state}>"
