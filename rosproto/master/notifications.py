"""The notifications of a master as plain values: what they contain, not how they are sent.

The registry and the parameter tree create them; the notifier sends them. A notification replaces an earlier
one to the same node with the same `key`: only the newest is still valid.
"""

from __future__ import annotations

from typing import NamedTuple


class PublisherUpdate(NamedTuple):
    """The complete list of a topic's publishers, for one subscriber (slave API publisherUpdate).

    Attributes:
        uri: XML-RPC URI of the subscriber.
        topic: Topic whose publishers changed.
        publishers: XML-RPC URIs of all its publishers now; may be empty.
    """

    uri: str
    topic: str
    publishers: tuple[str, ...]

    @property
    def key(self) -> tuple[str, str]:
        """Identifies the notifications to one node that replace each other."""
        return ("publisherUpdate", self.topic)


class ParamUpdate(NamedTuple):
    """A parameter's new value, for one subscriber (slave API paramUpdate).

    Attributes:
        uri: XML-RPC URI of the subscriber.
        parameter: Key with a trailing slash, as rosmaster sends it.
        value: The new value; `{}` when deleted.
    """

    uri: str
    parameter: str
    value: object

    @property
    def key(self) -> tuple[str, str]:
        """Identifies the notifications to one node that replace each other."""
        return ("paramUpdate", self.parameter)


class Shutdown(NamedTuple):
    """A request to end, for a node whose name was taken over by another one.

    The other fields describe that node; the notifier uses them to find out whether the process that listens
    at `uri` now is still that node (`slave_calls.py`).

    Attributes:
        uri: XML-RPC URI under which the name was registered before.
        name: The node's name.
        reason: Text for the node's log.
        publications: Topics it was registered as a publisher of.
        subscriptions: Topics it was registered as a subscriber of.
    """

    uri: str
    name: str
    reason: str
    publications: frozenset[str]
    subscriptions: frozenset[str]

    @property
    def key(self) -> tuple[str, str]:
        """Identifies the notifications to one node that replace each other."""
        return ("shutdown", self.name)


Notification = PublisherUpdate | ParamUpdate | Shutdown
