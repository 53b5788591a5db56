"""Which link leads to a publisher: inside this process, by datagrams, or over TCP."""

from __future__ import annotations

from rosproto.node.incoming.local_link import LocalLink
from rosproto.node.incoming.publisher_link import LinkOwner, PublisherLink
from rosproto.node.incoming.tcpros_link import TcprosLink


def make_link(subscription: LinkOwner, uri: str) -> PublisherLink:
    """A link to the publisher with that URI; not started yet."""
    context = subscription.context
    id = context.next_link_id()
    if context.local_nodes is not None and context.local_nodes.find(uri) is not None:
        return LocalLink(subscription, uri, id)
    if subscription.unreliable:
        from rosproto.node.incoming.udpros_link import UdprosLink

        return UdprosLink(subscription, uri, id)
    return TcprosLink(subscription, uri, id)
