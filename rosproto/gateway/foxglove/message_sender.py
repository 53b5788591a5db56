"""Hands the SDK the messages for one client, and keeps the newest while the client does not read."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rosproto.gateway.foxglove.channels import OfferedChannel
from rosproto.gateway.limits import GatewayLimits
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.gateway.outbox import Outbox

__all__ = ["ChannelReceiver", "MessageSender"]

BATCH = 1 << 20  # bytes of waiting messages handed to the SDK at once
PAUSE = 0.01  # seconds between two such batches


class MessageSender:
    """`send` is called in the node's threads, `pause` and `resume` in the proxy's; none of them waits.

    Args:
        limits: How much may wait.
        later: `later(seconds, function)` has it called in the proxy's thread.

    Attributes:
        sent, sent_bytes: Messages handed on.
    """

    def __init__(self, limits: GatewayLimits, later: Callable[[float, Callable[[], None]], None]) -> None:
        self.sent = self.sent_bytes = 0
        self._later = later
        self._outbox: Outbox[tuple[OfferedChannel, bytes, int]] = Outbox(limits)
        self._lock = threading.Lock()
        self._paused = False
        self._stopped = False

    @property
    def dropped(self) -> dict[str, int]:
        """Messages that were not sent because the client did not read, by topic."""
        return {str(key): count for key, count in self._outbox.dropped.items()}

    def send(self, channel: OfferedChannel, event: MessageEvent) -> None:
        """Send a message, now or when the client reads again."""
        data: bytes = event.once("bytes", lambda: bytes(event.data))
        stamp = event.stamp.to_nsec()
        with self._lock:
            if self._paused or len(self._outbox):
                self._outbox.put(channel.topic, len(data), (channel, data, stamp))
            else:
                self._log(channel, data, stamp)

    def _log(self, channel: OfferedChannel, data: bytes, stamp: int) -> None:
        if channel.closed or self._stopped:
            return
        channel.channel.log(data, log_time=stamp)
        self.sent += 1
        self.sent_bytes += len(data)

    def pause(self) -> None:
        """The client does not read: keep what comes."""
        self._paused = True

    def resume(self) -> None:
        """The client has caught up: send what was kept, in batches."""
        self._paused = False
        self._flush()

    def _flush(self) -> None:
        handed = 0
        with self._lock:
            while not self._paused and handed < BATCH:
                waiting = self._outbox.take()
                if waiting is None:
                    return
                if not waiting[0].closed:
                    self._log(*waiting)
                handed += len(waiting[1])
        if not self._paused:
            self._later(PAUSE, self._flush)

    def stop(self) -> None:
        """Send nothing more."""
        self._stopped = True

    def close(self) -> None:
        """Forget what is waiting."""
        self.stop()
        self._outbox.close()


class ChannelReceiver:
    """Receives the messages of one topic for one client.

    Args:
        channel: As the client was offered it.
        send: Takes each message.
        differs: Called when a publisher's definition is not the one that the client was told.
    """

    def __init__(
        self,
        channel: OfferedChannel,
        send: Callable[[OfferedChannel, MessageEvent], None],
        differs: Callable[[str, TopicDescription], None],
    ) -> None:
        self._channel = channel
        self._send = send
        self._differs = differs
        self._same: TopicDescription | None = None

    def offer(self, event: MessageEvent) -> None:
        """See `Receiver`."""
        description = event.description
        if description is not self._same:
            told = self._channel.schema
            if (description.md5sum, description.type_name) != (told.md5sum, told.type_name):
                self._differs(self._channel.topic, description)
                return  # the client would misread it; the channel that replaces this one sends it
            self._same = description
        self._send(self._channel, event)
