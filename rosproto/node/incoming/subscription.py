"""One subscribed topic of a node: a link to each publisher, and the node's subscribers that share the links.

Several `Subscriber` objects of a node may have the same topic; they share the links and the decoded messages.
The last one to close unregisters the topic.

The links follow the master's newest list of publishers. A list may come early, late or twice, or be empty
(docs/wire.md, 27).

Source: wiki.ros.org/ROS/Master_API (registerSubscriber), wiki.ros.org/ROS/Slave_API (publisherUpdate).
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Collection, Sequence

from rosproto.codec import AnyMsg, Message
from rosproto.errors import CodecError, LocalProtocolError, Md5sumMismatch
from rosproto.node.context import Context
from rosproto.node.definitions.md5sum_mismatch import (
    RevisedType,
    UnconvertibleMessage,
    note_differences,
    revised_type,
)
from rosproto.node.definitions.topic_type import ANY, TopicType
from rosproto.node.definitions.type_argument import learn_type
from rosproto.node.graph import api_client
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.registrations import RegistrationCall
from rosproto.node.incoming.delivery import Delivery, RevisedDelivery, encoded
from rosproto.node.incoming.local_link import LocalLink
from rosproto.node.incoming.publisher_link import PublisherLink
from rosproto.node.incoming.subscriber_queue import SubscriberQueue
from rosproto.node.incoming.tcpros_link import TcprosLink
from rosproto.node.stats import ConnectedLink, LinkStats
from rosproto.protocol.handshake import PublisherReply
from rosproto.sentence import both, say
from rosproto.transport.deadline import wait_for
from rosproto.transport.uri import parse_uri


def make_link(subscription: Subscription, uri: str) -> PublisherLink:
    """Make a link to a publisher: in this process, by datagrams, or over TCP; it is not started yet."""
    context = subscription.context
    id = context.next_link_id()
    if context.local_nodes is not None and context.local_nodes.find(uri) is not None:
        return LocalLink(subscription, uri, id)
    if subscription.unreliable:
        from rosproto.node.incoming.udpros_link import UdprosLink

        return UdprosLink(subscription, uri, id)
    return TcprosLink(subscription, uri, id)


MAX_ERRORS = 32


class Subscription:
    """A topic that this node subscribes to; a `Registration`.

    Attributes:
        name: Resolved topic.
        type: The requested type; the wildcard while the subscribers accept any.
        present_type: The decoded type; the wildcard until a publisher's header has a type.
        links: One for each publisher, by its URI in canonical form.
        connected_links: The connections of those whose messages can arrive now.
        errors: The latest errors of links and handshakes, the newest last.
        skipped: Messages of past sessions that were not decoded, since no subscriber keeps that many.
        unfit: Messages of other revisions that were dropped, since a value did not fit.
    """

    kind = "subscriber"

    def __init__(
        self, context: Context, name: str, type_: TopicType, *, tcp_nodelay: bool, unreliable: bool = False
    ) -> None:
        self.context = context
        self.name = name
        self.type = type_
        self.tcp_nodelay = tcp_nodelay
        self.unreliable = unreliable
        self.links: dict[str, PublisherLink] = {}
        self.connected_links: frozenset[ConnectedLink] = frozenset()
        self.errors: deque[Exception] = deque(maxlen=MAX_ERRORS)
        self.skipped = 0
        self.unfit = 0
        self.present_type = type_
        self._condition = threading.Condition()
        self._queues: list[SubscriberQueue] = []
        self._latched: dict[object, Message] = {}  # by link
        self._generation = 0
        self._closed = False
        self._delivery: Delivery | None = None
        self._revised_deliveries: dict[RevisedType, Delivery] = {}

    @property
    def delivery(self) -> Delivery:
        """Delivers messages to the present set of subscribers; replaced when the set changes.

        Made on first use: its decoder takes 2 ms, too long for a constructor.
        """
        delivery = self._delivery
        if delivery is None:
            with self._condition:
                delivery = self._delivery = self._delivery or Delivery(self._queues, self.present_type)
        return delivery

    # -- master ---------------------------------------------------------------------------------------------

    def registration_call(self) -> RegistrationCall:
        generation = self._generation
        return RegistrationCall(
            "registerSubscriber",
            (self.name, self.type.name, self.context.uri),
            lambda answer: self._registered(api_client.as_str_list(answer), generation),
        )

    def _registered(self, uris: Sequence[str], generation: int) -> None:
        # An update that came before the answer is newer.
        if generation == self._generation:
            self.update_publishers(uris, keep_connected=True)

    def unregister(self, master: MasterClient) -> int:
        return master.unregister_subscriber(self.name, self.context.uri)

    def update_publishers(self, uris: Sequence[str], *, keep_connected: bool = False) -> None:
        """Connect to the publishers that are new in the master's list; close the links to those not in it.

        With `keep_connected`, connected links are kept until their connection ends. This is used when we
        register again: a restarted master knows no publishers, and neither roscpp nor rospy registers again,
        but their publishers go on sending. Otherwise the master has news: a publisher that is named again may
        have been restarted, so links that wait try at once.
        """
        wanted = {_canonical(uri): uri for uri in uris}
        with self._condition:
            self._generation += 1
            if self._closed:
                return
            if len(wanted) > self.context.limits.publishers:
                wanted = self._as_many_as_allowed(wanted)
            kept = {
                key: link
                for key, link in self.links.items()
                if key not in wanted and keep_connected and link.connected
            }
            for key, link in self.links.items():
                link.named = key not in kept
            gone = [link for key, link in self.links.items() if key not in wanted and key not in kept]
            new = {key: uri for key, uri in wanted.items() if key not in self.links}
            if not keep_connected:
                self.nudge()
            for link in gone:
                self._latched.pop(link, None)
            links = {key: link for key, link in self.links.items() if key in wanted}
            made = {key: make_link(self, uri) for key, uri in new.items()}
            self.links = {**links, **kept, **made}
            self.link_changed()
        for link in gone:
            link.close()
        for link in made.values():
            link.start()

    def nudge(self) -> None:
        """Let links that wait try at once."""
        for link in list(self.links.values()):
            link.nudge()

    def _as_many_as_allowed(self, wanted: dict[str, str]) -> dict[str, str]:
        """Limit the links, which need a thread each, to `limits.publishers`; connected ones are kept."""
        limit = self.context.limits.publishers
        self.context.peer_log.warning(
            self.name,
            "! %s: the master lists %d publishers; only %d of them are connected (Limits.publishers)",
            self.name,
            len(wanted),
            limit,
        )
        first = [key for key in wanted if key in self.links and self.links[key].connected]
        rest = [key for key in wanted if key not in first]
        return {key: wanted[key] for key in [*first, *rest][:limit]}

    # -- queues -----------------------------------------------------------------------------------------

    def add_queue(self, queue: SubscriberQueue) -> None:
        """Add a subscriber; it gets the latched messages that arrived before."""
        with self._condition:
            if not queue.type.is_wildcard and self.present_type.is_wildcard:
                self._adopt(queue.type)
            queue.note_links(self.connected_links)
            latched = [self._as_wanted(message, queue.raw) for message in self._latched.values()]
            if latched:  # before any message that arrives from now on
                queue.hand_over(latched, time.time())
            self._queues.append(queue)
            self.renew_delivery()

    def _as_wanted(self, message: Message, raw: bool) -> Message:
        """A latched message, raw or decoded as the subscriber wants it."""
        if raw == isinstance(message, AnyMsg) or (not raw and self.present_type.is_wildcard):
            return message
        if not isinstance(message, AnyMsg):
            return encoded(message, message._connection_header)
        wanted = self.present_type.decode(message._buff, 0, len(message._buff))
        wanted._connection_header = message._connection_header
        return wanted

    def remove_queue(self, queue: SubscriberQueue) -> bool:
        """Remove a subscriber; True if it was the last one."""
        with self._condition:
            if queue in self._queues:
                self._queues.remove(queue)
            self.renew_delivery()
            return not self._queues

    def _adopt(self, type_: TopicType) -> None:
        """Request this type from now on instead of the wildcard."""
        self.type = self.present_type = type_

    def renew_delivery(self) -> None:
        """Replace the deliveries after a change of the subscribers or their queue sizes."""
        with self._condition:
            self._delivery = None
            self._revised_deliveries = {}

    def delivery_for(self, revised: RevisedType) -> Delivery:
        """As `delivery`, for a publisher that sends another revision of the type."""
        delivery = self._revised_deliveries.get(revised)
        if delivery is None:
            with self._condition:
                delivery = RevisedDelivery(self._queues, revised, self._drop_unfit)
                self._revised_deliveries[revised] = delivery
        return delivery

    def forget_revised(self, revised: RevisedType) -> None:
        """Drop the delivery of a session that has ended."""
        with self._condition:
            self._revised_deliveries.pop(revised, None)

    @property
    def queues(self) -> list[SubscriberQueue]:
        """The subscribers of this node."""
        return list(self._queues)

    # -- called by links ------------------------------------------------------------------------------------

    def learn(self, reply: PublisherReply, peer: str) -> RevisedType | None:
        """Check a publisher's type; a wildcard subscription adopts the first publisher's.

        Returns:
            How to decode this publisher's messages when it has another revision of the type; None when it
            has ours.

        Raises:
            Md5sumMismatch: It has another type, or an unknown revision of ours.
            RemoteProtocolError: Its definition cannot be used.
        """
        with self._condition:
            known = self.present_type
            if known.is_wildcard and all(queue.raw for queue in self._queues):
                return None
        if reply.md5sum == ANY and known.is_wildcard:
            raise Md5sumMismatch(
                f"{self.name}: {peer} publishes AnyMsg without stating the type; subscribe with AnyMsg"
                " (raw=True) for the bytes",
                name=self.name,
                peer=peer,
                type_name=ANY,
                md5sum=ANY,
                remote_type=reply.type_name,
                remote_md5sum=reply.md5sum,
            )
        if not known.is_wildcard:
            return None if known.md5sum == reply.md5sum else self._revise(reply, peer, known)
        learned = learn_type(
            reply.type_name, reply.md5sum, reply.message_definition, topic=self.name, peer=peer
        )
        with self._condition:
            if self.present_type.is_wildcard:
                self.present_type = learned
                self.renew_delivery()
            known = self.present_type
        return None if known.md5sum == learned.md5sum else self._revise(reply, peer, known)

    def _revise(self, reply: PublisherReply, peer: str, known: TopicType) -> RevisedType:
        mismatch = Md5sumMismatch(
            f"{self.name}: {peer} offers {reply.type_name} with md5sum {reply.md5sum}, but this subscription"
            f" decodes {known.name} with md5sum {known.md5sum}",
            name=self.name,
            peer=peer,
            type_name=known.name,
            md5sum=known.md5sum,
            remote_type=reply.type_name,
            remote_md5sum=reply.md5sum,
            message_definition=reply.message_definition,
        )
        if reply.type_name != known.name:
            raise mismatch
        revised = revised_type(
            self.context.definitions, known, reply.md5sum, reply.message_definition, mismatch
        )
        note_differences(self.context.peer_log, self.name, reply.callerid or peer, revised.conversion)
        return revised

    def hand_out(
        self,
        link: object,
        delivery: Delivery,
        batch: Sequence[Message],
        header: dict[str, str],
        revised: RevisedType | None,
    ) -> None:
        """Deliver messages that a link received for `delivery`.

        The latest latched message is kept for later subscribers, under the lock that adds subscribers: a
        subscriber added after `delivery` was made gets it exactly once.
        """
        if header.get("latching") == "1":
            with self._condition:
                self._keep_latched(link, batch, header)
                present = self.delivery if revised is None else self.delivery_for(revised)
            if present is not delivery:
                present.deliver_to_newcomers(delivery, batch, header)
        delivery.deliver(batch, header)

    def _keep_latched(self, link: object, batch: Sequence[Message], header: dict[str, str]) -> None:
        fitting = [message for message in batch if type(message) is not UnconvertibleMessage]
        if fitting and link in self.links.values():
            fitting[-1]._connection_header = header
            self._latched[link] = fitting[-1]

    def _drop_unfit(self, errors: list[CodecError]) -> None:
        """Count and report messages of another revision whose values do not fit."""
        self.unfit += len(errors)
        for error in errors:
            self.report(error)
        text = "! %s: messages are dropped that do not fit: %s"
        self.context.peer_log.warning(self.name, text, self.name, errors[0])

    def report(self, error: Exception) -> None:
        """Record the error of a link, and call the subscribers' `on_error`."""
        self.errors.append(error)
        for queue in self.queues:
            queue.report(error)

    def link_changed(self) -> None:
        """A link was made or lost."""
        with self._condition:
            before, links = self.connected_links, self.links.values()
            self.connected_links = frozenset(link.connection for link in links if link.connected)
            if self.connected_links != before:
                for queue in self._queues:
                    queue.note_links(self.connected_links)
            self._condition.notify_all()

    def link_closed(self, link: PublisherLink) -> None:
        """Called when the thread of a link ends."""
        self._latched.pop(link, None)
        if not link.named:  # no update of the master will remove it
            with self._condition:
                self.links = {key: other for key, other in self.links.items() if other is not link}
                self.link_changed()

    def reconnect(self) -> None:
        """Reconnect all links: connections from our old address are dead, perhaps without an error."""
        for link in list(self.links.values()):
            link.interrupt()

    # -- state ----------------------------------------------------------------------------------------------

    @property
    def connections(self) -> int:
        """Publishers whose messages can arrive now."""
        return sum(link.connected for link in self.links.values())

    def knows(self, publishers: Collection[str]) -> bool:
        """True if the links match these nodes; a link whose node name is unknown yet matches any."""
        names = {link.caller_id for link in list(self.links.values())}
        expected = min(len(publishers), self.context.limits.publishers)
        return len(self.links) == expected and names - {""} <= set(publishers)

    def wait_for(self, count: int, timeout: float | None) -> bool:
        """Wait until at least `count` publishers are connected; False after the timeout, in seconds."""
        with self._condition:
            wait_for(self._condition, lambda: self._closed or self.connections >= count, timeout)
            return self.connections >= count

    def why_silent(self) -> str:
        """The state of the publishers, for the text of a timeout."""
        links = list(self.links.values())
        if not links:
            return "no publisher is registered at the master"
        parts = []
        for link in links:
            how = "{node} is {state}" if link.last_error is None else "{node} is {state}: {why}"
            who, state = link.caller_id or link.uri, say(link.state.value)
            parts.append(say(how, node=who, state=state, why=link.last_error))
        if self.unfit:
            unfit = "messages of another revision that did not fit: {count}, the last error: {error}"
            parts.append(say(unfit, count=self.unfit, error=self.errors[-1]))
        return both(*parts)

    @property
    def skipped_so_far(self) -> int:
        """`skipped`, including the present sessions."""
        return self.skipped + sum(link.skipped for link in list(self.links.values()))

    def stats(self) -> list[LinkStats]:
        """One entry for each publisher that the master names."""
        return [link.stats() for link in list(self.links.values())]

    # -- end ------------------------------------------------------------------------------------------------

    def close(self, timeout: float = 1.0) -> None:
        """End all links; wait for their threads at most `timeout` seconds."""
        with self._condition:
            self._closed = True
            links = list(self.links.values())
            self.links = {}
            self._latched.clear()
            self.link_changed()
        for link in links:
            link.close()
        for link in links:
            link.join(timeout / max(1, len(links)) if len(links) > 10 else timeout)

    def check_type(self, type_: TopicType) -> None:
        """Check the type of another subscriber of this topic.

        Raises:
            LocalProtocolError: It does not fit the subscribed type.
        """
        if not self.present_type.fits(type_):
            raise LocalProtocolError(
                f"{self.name} is subscribed in this node as {self.present_type.name} (md5sum"
                f" {self.present_type.md5sum}), not as {type_.name} (md5sum {type_.md5sum}); close that"
                " subscriber first, or use raw=True"
            )


def _canonical(uri: str) -> str:
    """Key of a publisher: host and port, as roscpp has it; rospy compares the text (wire.md, fact 28)."""
    try:
        host, port = parse_uri(uri)
    except ValueError:
        return uri
    return f"{host}:{port}"
