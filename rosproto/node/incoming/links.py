"""Which link leads to a publisher: inside this process, by datagrams, or over TCP."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.node.incoming.local_link import LocalLink
from rosproto.node.incoming.publisher_link import PublisherLink
from rosproto.node.incoming.tcpros_link import TcprosLink

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

__all__ = ["make_link"]


def make_link(subscription: Subscription, uri: str) -> PublisherLink:
    """A link to the publisher with that URI; not started yet."""
    context = subscription.context
    id = context.next_link_id()
    if context.local_nodes is not None and context.local_nodes.find(uri) is not None:
        return LocalLink(subscription, uri, id)
    if subscription.unreliable:
        from rosproto.node.incoming.udpros_link import UdprosLink

        return UdprosLink(subscription, uri, id)
    return TcprosLink(subscription, uri, id)
