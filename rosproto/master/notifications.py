"""What the master tells nodes on its own accord, as plain values.

The registry and the parameter tree decide; the notifier carries out. Two notifications to one node with
the same `topic` of conversation (`key`) replace each other: only the newest still means anything.
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
        """What a later notification to the same node has to share to replace this one."""
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
        """What a later notification to the same node has to share to replace this one."""
        return ("paramUpdate", self.parameter)


class Shutdown(NamedTuple):
    """A request to end, for a node whose name was taken over by another one.

    The remaining fields say what was known of that node; the notifier uses them to find out whether the
    process that listens at `uri` now is still that node (`identity.py`).

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
        """What a later notification to the same node has to share to replace this one."""
        return ("shutdown", self.name)


Notification = PublisherUpdate | ParamUpdate | Shutdown
