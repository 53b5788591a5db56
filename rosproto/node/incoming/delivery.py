"""Delivers received messages to the node's subscribers of a topic; each message is decoded once.

A `Delivery` belongs to one fixed set of subscribers. The subscription makes a new one when the set changes,
so links need no lock to read it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from rosproto.codec import AnyMsg, Message, encode
from rosproto.errors import CodecError
from rosproto.node.definitions.md5sum_mismatch import UnconvertibleMessage
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.incoming.subscriber_queue import SubscriberQueue
from rosproto.protocol.framing import BytesLike, Decode


class Delivery:
    """Decodes received bytes and delivers the messages to one set of subscribers.

    Attributes:
        decode: `(buffer, start, end) -> message`: the decoder, or `raw_message`.
        owns: True if messages keep the buffer they are decoded from.
        newest: Of messages received at once, subscribers keep at most this many; None to keep all.
        offer_one: Takes a single message if the only subscriber has a callback; None to use `deliver`.
    """

    def __init__(self, queues: Sequence[SubscriberQueue], type_: TopicType) -> None:
        self._queues = tuple(queue for queue in queues if not queue.raw)
        self._raw_queues = tuple(queue for queue in queues if queue.raw)
        self._decode_later = type_.decode if self._queues and not type_.is_wildcard else raw_message
        self.decode: Decode[Message] = raw_message if self._raw_queues else self._decode_later
        self.owns = bool(self._raw_queues) or type_.may_be_large or type_.is_wildcard
        sizes = [queue.keeps for queue in queues]
        # What no subscriber would keep is not even delivered.
        self.newest = None if None in sizes else max((s for s in sizes if s is not None), default=1)
        self.offer_one: Callable[[Message], None] | None = (
            self._queues[0].offer_one if len(queues) == 1 and self._queues else None
        )

    def deliver(self, batch: Sequence[Message], header: dict[str, str]) -> None:
        """Deliver messages to every subscriber; runs in the link's thread."""
        stamp = time.time()
        for message in batch:
            message._connection_header = header
        if self._raw_queues:
            for queue in self._raw_queues:
                queue.offer(batch, stamp)
            if not self._queues:
                return
            batch = self._decode_all(batch, header)
            if not batch:  # no message of another revision could be converted
                return
        for queue in self._queues:
            queue.offer(batch, stamp)

    def deliver_to_newcomers(
        self, before: Delivery, batch: Sequence[Message], header: dict[str, str]
    ) -> None:
        """Deliver messages, received for the delivery `before`, to the subscribers added since."""
        stamp = time.time()
        batch = [message for message in batch if type(message) is not UnconvertibleMessage]
        for message in batch:
            message._connection_header = header
        for queue in self._queues:
            if queue not in before._queues and (decoded := self._decode_all(batch, header)):
                queue.offer(decoded, stamp)
        for queue in self._raw_queues:
            if queue not in before._raw_queues and batch:
                queue.offer([encoded(message, header) for message in batch], stamp)

    def _decode_all(self, batch: Sequence[Message], header: dict[str, str]) -> Sequence[Message]:
        return [self._decoded(m, header) if isinstance(m, AnyMsg) else m for m in batch]

    def _decoded(self, raw: AnyMsg, header: dict[str, str]) -> Message:
        message = self._decode_later(raw._buff, 0, len(raw._buff))
        message._connection_header = header
        return message


class RevisedDelivery(Delivery):
    """As `Delivery`, for a publisher of another revision: a message that cannot be converted is dropped.

    Args:
        queues, type_: As for `Delivery`.
        on_unfit: Called with the errors of the dropped messages; the link stays open.
    """

    def __init__(
        self,
        queues: Sequence[SubscriberQueue],
        type_: TopicType,
        on_unfit: Callable[[list[CodecError]], None],
    ) -> None:
        super().__init__(queues, type_)
        self._on_unfit = on_unfit
        self.offer_one = None

    def deliver(self, batch: Sequence[Message], header: dict[str, str]) -> None:
        batch = self._fitting(batch)
        if batch:
            super().deliver(batch, header)

    def _decode_all(self, batch: Sequence[Message], header: dict[str, str]) -> Sequence[Message]:
        return self._fitting(super()._decode_all(batch, header))

    def _fitting(self, batch: Sequence[Message]) -> Sequence[Message]:
        unfit = [item.error for item in batch if type(item) is UnconvertibleMessage]
        if not unfit:
            return batch
        self._on_unfit(unfit)
        return [item for item in batch if type(item) is not UnconvertibleMessage]


def encoded(message: Message, header: dict[str, str] | None) -> AnyMsg:
    """The `AnyMsg` of a received message, for raw subscribers."""
    if isinstance(message, AnyMsg):
        return message
    data = encode(message)
    raw = raw_message(data, 0, len(data))
    raw._connection_header = header
    return raw


def raw_message(buffer: BytesLike, start: int, end: int) -> AnyMsg:
    """An `AnyMsg` with the bytes of one message."""
    message = AnyMsg()
    message._buff = (
        buffer
        if start == 0 and end == len(buffer) and type(buffer) is bytes
        else bytes(memoryview(buffer)[start:end])
    )
    return message
