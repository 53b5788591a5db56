"""Who gets the messages of a topic: one subscriber's inbox or callback, as links and deliveries see it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rosproto.logs import get_logger
from rosproto.node.events import is_interrupt
from rosproto.node.incoming.callbacks import CallbackRunner, InlineCaller
from rosproto.node.incoming.inbox import Inbox
from rosproto.node.revisions.topic_types import TopicType

_log = get_logger("rosproto.node")


class Recipient:
    """The receiving end of one `Subscriber`; links hand it messages and tell it errors.

    Args:
        topic: Resolved name.
        type_: The type asked for.
        callback: Called with each message; None: they wait in `inbox`.
        queue_size: Most messages that wait.
        raw: Wants `AnyMsg` with the encoded bytes.
        on_error: Called with each error of a link.
        inline: Call back in the thread that received the message, however long it takes.
        renew: Called when the subscription's delivery has to be made anew.

    Attributes:
        inbox: What was received and not taken yet.
        runner: Calls the callback; None without one.
        offer: `(messages, receive time)`: takes what a link received.
        offer_one: The same for one message, where a callback takes it at once; else None.
    """

    offer: Callable[[Sequence[Any], float], None]
    offer_one: Callable[[Any], None] | None

    def __init__(
        self,
        topic: str,
        type_: TopicType,
        *,
        callback: Callable[[Any], object] | None,
        queue_size: int,
        raw: bool,
        on_error: Callable[[Exception], object] | None,
        inline: bool,
        renew: Callable[[], None],
    ) -> None:
        self.topic = topic
        self.type = type_
        self.raw = raw
        self.inbox = Inbox(queue_size)
        self.runner: CallbackRunner | InlineCaller | None = None
        if callback:
            kind = InlineCaller if inline else CallbackRunner
            self.runner = kind(callback, self.inbox, topic)
        self._on_error = on_error
        self._renew = renew
        self.offer = self.inbox.put
        self.offer_one = None
        if self.runner is not None:
            self.offer, self.offer_one = self.runner.offer, self.runner.offer_one

    def hand_over(self, messages: Sequence[Any], stamp: float) -> None:
        """Take latched messages of the topic; the thread that subscribes does not call the callback."""
        if self.runner is None:
            self.offer(messages, stamp)
        else:
            self.runner.begin(messages, stamp)

    @property
    def keeps(self) -> int | None:
        """How many of the messages received at once are delivered; None for all (to a quick callback)."""
        return None if self.runner is not None and self.runner.takes_all else self.inbox.size

    @property
    def queue_size(self) -> int:
        """Most messages that wait for the program; may be changed."""
        return self.inbox.size

    @queue_size.setter
    def queue_size(self, size: int) -> None:
        self.inbox.size = size
        self._renew()

    def report(self, error: Exception) -> None:
        """A link of the topic failed: tell who asked to be told."""
        if self._on_error is not None:
            try:
                self._on_error(error)
            except BaseException as problem:  # as in callbacks.py
                if is_interrupt(problem):
                    raise
                _log.exception("! %s: on_error raised", self.topic)

    def end(self) -> None:
        """Nothing more is taken; whoever waits is woken."""
        self.inbox.close()

    def abandon(self) -> None:
        """In a fork of this process: ended, whoever held the lock in the parent."""
        self.inbox.abandon()
