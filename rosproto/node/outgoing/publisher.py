"""Publisher: what a program holds to publish a topic."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any

from rosproto.codec import Message
from rosproto.coercion import as_float
from rosproto.errors import LocalProtocolError, RosError, RosTimeout
from rosproto.node.context import Context
from rosproto.node.outgoing.publication import Publication
from rosproto.node.stats import LinkStats
from rosproto.transport.os_errors import translate


class Publisher:
    """Publishes one topic; made by `Node.publisher`. Close it, or use it in a `with` block.

    Attributes:
        latch: A subscriber that comes later gets the last message published here.
        queue_size: Most messages that wait for one slow subscriber; the oldest is dropped and counted.
        on_connect: Called with the caller id of each new subscriber, in a thread of the library.
        on_disconnect: The same for each subscriber that has left.
        header: Gives more fields of the header that a new subscriber gets; None for none.
        linger: Whether the system delivers what is on its way when the program is killed.
    """

    def __init__(
        self,
        context: Context,
        on_close: Callable[[Publisher, Publication], None],
        publication: Publication,
        *,
        latch: bool,
        queue_size: int,
        on_connect: Callable[[str], object] | None,
        on_disconnect: Callable[[str], object] | None = None,
        header: Callable[[], Mapping[str, str]] | None = None,
        linger: bool = True,
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

    def connected(self, caller_id: str) -> None:
        """A subscriber came; told in a thread of the library."""
        if self.on_connect is not None:
            self.on_connect(caller_id)

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
        """What each present subscriber decodes, by caller id: `message_class`, or a revision of it."""
        return {link.caller_id: cls for link, cls in self._publication.wanted}

    def publish(self, message: Any = None, **fields: Any) -> None:
        """Send a message to everybody who subscribes; never waits for a slow subscriber.

        The message is encoded before this returns: changing it afterwards changes nothing sent. It is not
        changed either: `header.seq` is counted in the bytes sent. Without a subscriber (and not latched)
        nothing is encoded, so wrong values are not noticed then.

        What a subscriber's connection does not take at once waits in its queue of `queue_size` messages, the
        oldest of which is dropped (`stats()` counts).

        Args:
            message: A message of the type, or its encoded bytes (`bytes`, or an `AnyMsg` of a raw
                subscription), which are relayed as they are.
            **fields: Instead of `message`, fields of a new one.

        Raises:
            CodecError: A value does not fit its field, or the message is of another type.
            LocalProtocolError: This publisher is closed.
        """
        if self._closed:
            raise LocalProtocolError(f"{self.topic}: this publisher is closed; make another one to publish")
        try:
            if message is None or fields:
                message = self._message_of(message, fields)
            self._publication.publish(self, message)
        except OSError as error:  # the first message imports what encodes it, and no file may be left to open
            if isinstance(error, RosError):
                raise
            raise translate(error, f"publish {self.topic}", "") from error

    def publish_to(self, caller_id: str, data: bytes) -> bool:
        """Send a message to one subscriber only: the newest connection of that node.

        Args:
            caller_id: Name of the subscriber's node, as `on_connect` tells it.
            data: The encoded message.

        Returns:
            False when no such subscriber is connected.
        """
        return self._publication.send_to(caller_id, data)

    def _message_of(self, message: Any, fields: dict[str, Any]) -> Message:
        if message is not None:
            raise TypeError("publish() takes a message or fields, not both")
        return self.message_class(**fields)

    def wait_for_connection(self, timeout: float | None = 5.0, count: int = 1) -> None:
        """Wait until somebody subscribes: a message published before that reaches nobody.

        Args:
            timeout: Seconds; None waits for ever.
            count: How many subscribers.

        Raises:
            RosTimeout: They did not come; the text names what was seen.
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
        """Wait until every message published so far is in the operating system's hands.

        Raises:
            RosTimeout: A subscriber is too slow.
        """
        self._publication.flush(timeout)

    def wait_arrived(self, timeout: float = 5.0) -> bool | None:
        """Wait until everything published so far is on the computers of its subscribers.

        `flush` tells that this computer has taken it; a network that loses packets may deliver it much later,
        or never.

        Returns:
            True when it is there, also when a subscriber has gone; False when it is not after `timeout`
            seconds; None, at once, where that is not known: on Windows and macOS, and over UDPROS.
        """
        return self._publication.wait_arrived(timeout)

    def stats(self) -> Sequence[LinkStats]:
        """Counters per connected subscriber (shared by all publishers of the topic in this node)."""
        return self._publication.stats()

    def end(self) -> None:
        """As `close`, for a node that closes: the topic is off the master already."""
        self._closed = True

    def close(self) -> None:
        """Stop publishing; the last publisher of the topic takes it off the master. May be called twice."""
        if not self._closed:
            self._closed = True
            self._on_close(self, self._publication)

    def __enter__(self) -> Publisher:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{self.connections} subscribers"
        return f"<Publisher {self.topic} {self.type_name}, {state}>"
