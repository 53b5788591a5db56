"""What other threads leave for the one that owns the order machine: messages, events, flags, and due times.

Messages wait in lanes, each with a room of its own, so that no flood takes the place of what stops the robot:

    lane        what                                      room   when it is full
    -----------------------------------------------------------------------------------------------------------
    STOP        cancelOrder, startPause                     64   one whose kind comes again later makes room
    INSTANT     other instant actions                       32   the new one is dropped
    ORDER       orders and updates                           8   the new one is dropped
    MALFORMED   what does not fit                            8   the new one is dropped

A lane is about room, not about rank: messages are read in the order in which they came, so that a cancel
never overtakes the order that it is for. At most 48 others stand before a stop. What is dropped is counted.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from enum import Enum
from typing import NamedTuple

from woosh_pure.fleet.messages.elements import InstantActions, Order
from woosh_pure.fleet.order.events import Event, MalformedMessage


class MessageKind(Enum):
    """Where a message waits; the value says in words what waits there."""

    STOP = "cancelOrder or startPause"
    INSTANT = "other instant actions"
    ORDER = "orders"
    MALFORMED = "messages that do not fit"


CAPACITY = {MessageKind.STOP: 64, MessageKind.INSTANT: 32, MessageKind.ORDER: 8, MessageKind.MALFORMED: 8}
"""Messages that wait in each lane."""
MOST_MESSAGES = sum(CAPACITY.values())
"""Messages of a fleet manager that wait."""


Message = Order | InstantActions | MalformedMessage


def message_kind(message: Message) -> MessageKind:
    """The lane of a message."""
    if isinstance(message, MalformedMessage):
        return MessageKind.MALFORMED
    if isinstance(message, Order):
        return MessageKind.ORDER
    return MessageKind.STOP if _stops(message) else MessageKind.INSTANT


def _stops(message: Message) -> set[str]:
    """The actions of a message that stop the vehicle, by their types."""
    actions = message.actions if isinstance(message, InstantActions) else ()
    return {action.type for action in actions} & {"cancelOrder", "startPause"}


class InboxContents(NamedTuple):
    """What has been left since the last look.

    Attributes:
        flags: What has changed, by a word.
        events: What the parts of the vehicle have reported, in its order.
        message: The oldest message of the fleet manager that waits; None where there is none.
    """

    flags: set[str]
    events: list[Event]
    message: Message | None


class Inbox:
    """One reader, any number of writers.

    Attributes:
        due: When something is to be done, by the monotonic clock; the reader's own.
        dropped: Messages for which there was no room, by lane.
        closed: Nothing is read any more.
    """

    def __init__(self) -> None:
        self.due: dict[str, float] = {}
        self.dropped: Counter[MessageKind] = Counter()
        self.closed = False
        self._wake = threading.Condition()
        self._flags: set[str] = set()
        self._events: list[Event] = []
        self._waiting: list[tuple[MessageKind, Message]] = []  # in the order in which they came
        self._count: Counter[MessageKind] = Counter()

    def flag(self, name: str) -> None:
        """Say that something has changed."""
        with self._wake:
            self._flags.add(name)
            self._wake.notify_all()

    def report(self, event: Event) -> None:
        """Leave an event of the robot; none is ever dropped."""
        with self._wake:
            self._events.append(event)
            self._wake.notify_all()

    def add_message(self, message: Message) -> bool:
        """Leave a message; False when another one of its kind or it itself is dropped for want of room."""
        lane = message_kind(message)
        with self._wake:
            room = self._count[lane] < CAPACITY[lane]
            if not room:
                self.dropped[lane] += 1
                self._flags.add("dropped")
                if lane is MessageKind.STOP:
                    self._make_room_for_stop(message)
            if room or lane is MessageKind.STOP:
                self._waiting.append((lane, message))
                self._count[lane] += 1
            self._wake.notify_all()
            return room

    def _make_room_for_stop(self, message: Message) -> None:
        """Drop the oldest stop whose kinds come again behind it. There is one: kinds are two, stops many."""
        behind, oldest = _stops(message), -1
        for n in reversed(range(len(self._waiting))):
            lane, each = self._waiting[n]
            if lane is MessageKind.STOP:
                if _stops(each) <= behind:
                    oldest = n
                behind |= _stops(each)
        del self._waiting[oldest]
        self._count[MessageKind.STOP] -= 1

    @property
    def waiting_messages(self) -> int:
        """How many messages have not been read."""
        return len(self._waiting)

    @property
    def stop_waits(self) -> bool:
        """Whether a message that stops the vehicle has not been read."""
        return self._count[MessageKind.STOP] > 0

    def close(self) -> bool:
        """Wake the reader up for the last time; False when that was done before."""
        with self._wake:
            first, self.closed = not self.closed, True
            self._wake.notify_all()
            return first

    def wait(self) -> InboxContents | None:
        """Wait until something is left or due, and take it; None when the inbox is closed."""
        with self._wake:
            while not (self.closed or self._flags or self._events or self._waiting):
                wait = min(self.due.values()) - time.monotonic()
                if wait <= 0.0:
                    break
                self._wake.wait(wait)
            if self.closed:
                return None
            message = None
            if self._waiting:
                lane, message = self._waiting.pop(0)
                self._count[lane] -= 1
            left = InboxContents(self._flags, self._events, message)
            self._flags, self._events = set(), []
            return left
