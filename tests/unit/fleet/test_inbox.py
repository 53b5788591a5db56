"""The lanes in which messages of a fleet manager wait: what stops always has room."""

from __future__ import annotations

import random

import pytest

from tests.support.fleet import action, instant, order_json
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.fleet.inbox import CAPACITY, MAX_MESSAGES, Inbox, Message, MessageKind, message_kind
from woosh_pure.fleet.messages.elements import InstantActions
from woosh_pure.fleet.messages.parsing import Invalid, read_instant_actions, read_order
from woosh_pure.fleet.order.events import MalformedMessage

CALL = CallScope()
ORDER = read_order(order_json())
MALFORMED = MalformedMessage({}, Invalid("", "an object", 3))


def told(*kinds: str, name: str = "x") -> InstantActions:
    return read_instant_actions(instant(*(action(f"{name}{n}", kind) for n, kind in enumerate(kinds))))


def read(inbox: Inbox) -> list[Message]:
    """What waits."""
    found = []
    while inbox.waiting_messages:
        left = inbox.wait()
        assert left is not None
        assert left.message is not None
        found.append(left.message)
    return found


@pytest.mark.parametrize(
    ("message", "lane"),
    [
        (ORDER, MessageKind.ORDER),
        (MALFORMED, MessageKind.MALFORMED),
        (told("stateRequest"), MessageKind.INSTANT),
        (told("stopPause"), MessageKind.INSTANT),
        (told("startPause"), MessageKind.STOP),
        (told("beep", "cancelOrder"), MessageKind.STOP),
    ],
)
def test_each_message_has_its_lane(message: Message, lane: MessageKind) -> None:
    """One that stops among others makes all of the message a stop."""
    assert message_kind(message) is lane


@pytest.mark.promise("64 messages that stop, 32 of other instant actions, 8 orders, 8 invalid")
@pytest.mark.parametrize("message", [ORDER, MALFORMED, told("stateRequest")])
def test_a_full_lane_drops_what_comes_and_counts_it(message: Message) -> None:
    """And leaves the capacity of other kinds alone."""
    inbox, lane = Inbox(), message_kind(message)
    taken = [inbox.add_message(message, CALL) for _ in range(500)]
    assert taken.count(True) == inbox.waiting_messages == CAPACITY[lane]
    assert inbox.dropped == {lane: 500 - CAPACITY[lane]}
    left = inbox.wait()
    assert left is not None
    assert left.flags == {"dropped"}
    for other in (ORDER, MALFORMED, told("stateRequest"), told("cancelOrder")):
        assert inbox.add_message(other, CALL)


def test_messages_are_read_in_the_order_in_which_they_came() -> None:
    """A cancel never overtakes the order that it is for."""
    inbox = Inbox()
    sent = [
        told("stateRequest"),
        ORDER,
        told("cancelOrder"),
        MALFORMED,
        told("startPause"),
        told("stopPause"),
    ]
    for message in sent:
        inbox.add_message(message, CALL)
    assert read(inbox) == sent


@pytest.mark.promise("a flood takes no room from `cancelOrder` and `startPause`")
@pytest.mark.parametrize("seed", range(20))
def test_whatever_comes_the_last_of_each_stop_is_kept(seed: int) -> None:
    """In a flood of everything, stops too: the newest cancel and the newest pause are read, and nothing is
    beyond its bound."""
    chance = random.Random(seed)
    inbox, last = Inbox(), dict[str, InstantActions]()
    for n in range(1000):
        kinds = chance.choice(
            (("cancelOrder",), ("startPause",), ("startPause", "cancelOrder"), ("beep",), ())
        )
        message = told(*kinds, name=f"n{n}-") if kinds else chance.choice((ORDER, MALFORMED))
        inbox.add_message(message, CALL)
        assert inbox.waiting_messages <= MAX_MESSAGES
        if isinstance(message, InstantActions):
            last |= {kind: message for kind in kinds if kind != "beep"}
    found = read(inbox)
    assert [message for message in found if message is last["cancelOrder"]]
    assert [message for message in found if message is last["startPause"]]
    assert not inbox.stop_waits
    assert inbox.dropped.total() == 1000 - len(found)
