"""`Inbox`: the queue of the vehicle's thread. Other threads put messages, events and flags into it.

Each kind of message has a capacity, so that a flood of others cannot displace a message that stops the robot:

    kind        messages                  capacity   when full
    ---------------------------------------------------------------------------------------
    STOP        cancelOrder, startPause         64   an older, repeated one is dropped
    INSTANT     other instant actions           32   the new one is dropped
    ORDER       orders and updates               8   the new one is dropped
    MALFORMED   malformed messages               8   the new one is dropped

Messages of all kinds are read in the order of their arrival, so that a cancel never overtakes its order. At
most 48 others are ahead of a stop. Dropped messages are counted.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from enum import Enum
from typing import NamedTuple

from woosh_pure.connection.call_scope import CallScope
from woosh_pure.fleet.messages.elements import InstantActions, Order
from woosh_pure.fleet.order.events import Event, MalformedMessage


class MessageKind(Enum):
    """The kind of a message; the value names it in words."""

    STOP = "cancelOrder or startPause"
    INSTANT = "other instant actions"
    ORDER = "orders"
    MALFORMED = "messages that do not fit"


CAPACITY = {MessageKind.STOP: 64, MessageKind.INSTANT: 32, MessageKind.ORDER: 8, MessageKind.MALFORMED: 8}
"""Messages of each kind that may wait."""
MAX_MESSAGES = sum(CAPACITY.values())
"""Messages of all kinds that may wait."""


Message = Order | InstantActions | MalformedMessage


def message_kind(message: Message) -> MessageKind:
    """The kind of a message."""
    if isinstance(message, MalformedMessage):
        return MessageKind.MALFORMED
    if isinstance(message, Order):
        return MessageKind.ORDER
    return MessageKind.STOP if _stops(message) else MessageKind.INSTANT


def _stops(message: Message) -> set[str]:
    """The types of a message's actions that stop the vehicle."""
    actions = message.actions if isinstance(message, InstantActions) else ()
    return {action.type for action in actions} & {"cancelOrder", "startPause"}


class InboxContents(NamedTuple):
    """What `Inbox.wait` returns.

    Attributes:
        flags: Names of what has changed.
        events: Events of the robot, in their order.
        message: The oldest message of the fleet manager; None if none waits.
        call: The scope that was added with it.
    """

    flags: set[str]
    events: list[Event]
    message: Message | None
    call: CallScope


class Inbox:
    """A queue for one reader and any number of writers.

    Attributes:
        due: Due times by the monotonic clock; only the reader uses them.
        dropped: Number of dropped messages of each kind.
        closed: Whether `close` was called.
    """

    def __init__(self) -> None:
        self.due: dict[str, float] = {}
        self.dropped: Counter[MessageKind] = Counter()
        self.closed = False
        self._wake = threading.Condition()
        self._flags: set[str] = set()
        self._events: list[Event] = []
        self._waiting: list[tuple[MessageKind, Message, CallScope]] = []  # in the order of arrival

    def flag(self, name: str) -> None:
        """Set a flag."""
        with self._wake:
            self._flags.add(name)
            self._wake.notify_all()

    def report(self, event: Event) -> None:
        """Add an event of the robot; events are never dropped."""
        with self._wake:
            self._events.append(event)
            self._wake.notify_all()

    def add_message(self, message: Message, call: CallScope) -> bool:
        """Add a message with its scope; False if it, or for a stop an older one, was dropped."""
        kind = message_kind(message)
        with self._wake:
            fits = self._count(kind) < CAPACITY[kind]
            if not fits:
                self.dropped[kind] += 1
                self._flags.add("dropped")
                if kind is MessageKind.STOP:
                    self._make_room_for_stop(message)
            if fits or kind is MessageKind.STOP:
                self._waiting.append((kind, message, call))
            self._wake.notify_all()
            return fits

    def _make_room_for_stop(self, message: Message) -> None:
        """Drop the oldest stop whose action types are repeated later. One exists: there are two types
        only."""
        behind, oldest = _stops(message), -1
        for n in reversed(range(len(self._waiting))):
            stops = _stops(self._waiting[n][1])
            if stops and stops <= behind:
                oldest = n
            behind |= stops
        del self._waiting[oldest]

    def _count(self, kind: MessageKind) -> int:
        return sum(each is kind for each, _, _ in self._waiting)

    @property
    def waiting_messages(self) -> int:
        """Number of waiting messages."""
        return len(self._waiting)

    @property
    def stop_waits(self) -> bool:
        """Whether a message that stops the vehicle waits."""
        with self._wake:
            return self._count(MessageKind.STOP) > 0

    def close(self) -> bool:
        """Close the inbox and wake the reader; False if it was closed already."""
        with self._wake:
            first, self.closed = not self.closed, True
            self._wake.notify_all()
            return first

    def wait(self) -> InboxContents | None:
        """Wait until something arrives or is due, and take it; None when the inbox is closed."""
        with self._wake:
            while not (self.closed or self._flags or self._events or self._waiting):
                wait = min(self.due.values()) - time.monotonic()
                if wait <= 0.0:
                    break
                self._wake.wait(wait)
            if self.closed:
                return None
            waiting = self._waiting.pop(0)[1:] if self._waiting else (None, CallScope())
            contents = InboxContents(self._flags, self._events, *waiting)
            self._flags, self._events = set(), []
            return contents
