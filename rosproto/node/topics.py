"""The topics of one node: publications, subscriptions, and the slave API's data about them.

Source: wiki.ros.org/ROS/Slave_API for the shapes of getBusStats and getBusInfo.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from rosproto.errors import LocalProtocolError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.graph.listening import refuse
from rosproto.node.incoming.subscriber import Subscriber
from rosproto.node.incoming.subscriber_queue import SubscriberQueue
from rosproto.node.incoming.subscription import Subscription
from rosproto.node.outgoing import datagram_link
from rosproto.node.outgoing.publication import Publication
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.stats import LinkStats
from rosproto.protocol.udpros import DatagramRequest
from rosproto.transport.deadline import Deadline


class NameLocks:
    """A lock for each name in use."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._locks: dict[str, tuple[threading.Lock, int]] = {}  # with the number of holders and waiters

    @contextmanager
    def hold(self, name: str, deadline: Deadline | None = None) -> Iterator[None]:
        """Hold the lock of `name`.

        Raises:
            RosTimeout: Another thread held it until the deadline.
        """
        with self._lock:
            lock, users = self._locks.get(name, (threading.Lock(), 0))
            self._locks[name] = (lock, users + 1)
        left = None if deadline is None else deadline.remaining()
        got = lock.acquire(timeout=-1 if left is None else max(0.0, left))
        try:
            if not got:
                assert deadline is not None
                raise RosTimeout(
                    f"{name}: another thread has been opening or closing it for {deadline.seconds:g} s;"
                    " does the master answer?",
                    what=name,
                    seconds=deadline.seconds,
                )
            yield
        finally:
            if got:
                lock.release()
            with self._lock:
                lock, users = self._locks[name]
                if users == 1:
                    del self._locks[name]
                else:
                    self._locks[name] = (lock, users - 1)

    def __len__(self) -> int:
        return len(self._locks)


_log = get_logger("rosproto.node")


class TopicTable:
    """Publications and subscriptions of one node by resolved name; safe from any thread.

    A topic's lock is held during the master calls that open and close it, so that closing the last subscriber
    and opening a new one do not overlap. Lookups take no lock: the node must answer the master's calls while
    it waits for the master's answer.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._publications: dict[str, Publication] = {}
        self._subscriptions: dict[str, Subscription] = {}
        self._publishing, self._subscribing = NameLocks(), NameLocks()

    # -- opening and closing --------------------------------------------------------------------------------

    def open_publisher(self, name: str, type_: TopicType, **options: Any) -> Publisher:
        """See `Node.publisher`; `options` are those of `Publisher`."""
        with self._publishing.hold(name):
            publication = self._publications.get(name)
            new = publication is None
            if publication is None:
                publication = Publication(self._context, name, type_)
            elif publication.type.md5sum != type_.md5sum:
                raise LocalProtocolError(
                    f"{name} is published by this node as {publication.type.name} (md5sum"
                    f" {publication.type.md5sum}), not as {type_.name} (md5sum {type_.md5sum}); close that"
                    " publisher first"
                )
            publisher = Publisher(self._context, self.close_publisher, publication, **options)
            publication.add_handle(publisher)
            self._publications[name] = publication
            if new:
                try:
                    self._context.registrations.register_in_batch(
                        publication, partial(_close_publishers, publication)
                    )
                except BaseException:
                    del self._publications[name]
                    publisher.end()
                    publication.close()
                    raise
            return publisher

    def close_publisher(self, publisher: Publisher, publication: Publication, wait: float = 0.0) -> None:
        """See `Publisher.close`."""
        with self._publishing.hold(publication.name):
            if not publication.remove_handle(publisher):
                return
            if self._publications.get(publication.name) is publication:
                del self._publications[publication.name]
            if wait:
                publication.finish(wait)
            self._context.registrations.remove(publication)
        publication.close()

    def open_subscriber(
        self,
        name: str,
        type_: TopicType,
        *,
        tcp_nodelay: bool = False,
        unreliable: bool = False,
        deadline: Deadline | None = None,
        **options: Any,
    ) -> Subscriber:
        """See `Node.subscriber`; `options` are those of `SubscriberQueue`.

        `deadline` limits the waits for the master and for other threads.
        """
        with self._subscribing.hold(name, deadline):
            subscription = self._subscriptions.get(name)
            new = subscription is None
            if subscription is None:
                subscription = Subscription(
                    self._context, name, type_, tcp_nodelay=tcp_nodelay, unreliable=unreliable
                )
            else:
                subscription.check_type(type_)
            queue = SubscriberQueue(name, type_, renew=subscription.renew_delivery, **options)
            subscriber = Subscriber(
                self._context,
                subscription,
                queue,
                on_close=partial(self._close_subscriber, queue, subscription),
            )
            subscription.add_queue(queue)
            self._subscriptions[name] = subscription
            if new:
                try:
                    self._context.registrations.register_in_batch(
                        subscription,
                        partial(self._close_subscribers, subscription),
                        None if deadline is None else deadline.remaining(),
                    )
                except BaseException:
                    del self._subscriptions[name]
                    queue.end()
                    subscription.close()
                    raise
            return subscriber

    def _close_subscriber(self, queue: SubscriberQueue, subscription: Subscription) -> None:
        """See `Subscriber.close`."""
        with self._subscribing.hold(subscription.name):
            if not subscription.remove_queue(queue):
                return
            if self._subscriptions.get(subscription.name) is subscription:
                del self._subscriptions[subscription.name]
            self._context.registrations.remove(subscription)
        subscription.close()

    def _close_subscribers(self, subscription: Subscription) -> None:
        """Close the handles after a failed registration."""
        for queue in subscription.queues:
            queue.end()
            self._close_subscriber(queue, subscription)

    def close(self) -> None:
        """End every link; the topics are already unregistered."""
        publications, subscriptions = list(self._publications.values()), list(self._subscriptions.values())
        self._publications, self._subscriptions = {}, {}
        for publication in publications:
            for publisher in publication.handles:
                publisher.end()
            publication.close()
        for subscription in subscriptions:
            for queue in subscription.queues:
                queue.end()
            subscription.close(0.0)
        for subscription in subscriptions:
            subscription.close(0.5)

    def abandon(self) -> None:
        """Mark all handles as closed in a forked process, without taking a lock."""
        for publication in self._publications.values():
            for publisher in publication.handles:
                publisher.end()
        for subscription in self._subscriptions.values():
            for queue in subscription.queues:
                queue.abandon()

    # -- lookups --------------------------------------------------------------------------------------------

    def publication(self, name: str) -> Publication | None:
        """The publication with that name."""
        return self._publications.get(name)

    def subscription(self, name: str) -> Subscription | None:
        """The subscription with that name."""
        return self._subscriptions.get(name)

    def accept(self, sock: socket.socket, fields: dict[str, str], peer: tuple[str, int]) -> None:
        """Accept a subscriber; its header names the topic."""
        publication = self._publications.get(fields["topic"])
        if publication is None:
            text = f"{self._context.name} does not publish {fields['topic'][:200]}"
            _log.debug("! %s:%s: %s", *peer[:2], text)
            refuse(sock, text)
        else:
            publication.accept(sock, fields, peer)

    def links_changed_address(self) -> None:
        """Drop the connections from our old address after it changed."""
        for subscription in list(self._subscriptions.values()):
            subscription.reconnect()
        for publication in list(self._publications.values()):
            publication.drop_links()

    def woke_up(self) -> None:
        """Reconnect after this computer slept: publishers may have closed links, and sent messages are late.

        Links to subscribers stay, since most subscribers (rospy) do not reconnect after a close.
        """
        for subscription in list(self._subscriptions.values()):
            subscription.reconnect()

    def datagram_links(self) -> list[datagram_link.DatagramLink]:
        """The subscribers that get datagrams, of all topics."""
        return [
            link
            for publication in list(self._publications.values())
            for link in publication.all_links
            if isinstance(link, datagram_link.DatagramLink)
        ]

    def link_stats(self) -> list[LinkStats]:
        """Every link of every topic."""
        topics: list[Publication | Subscription] = [
            *self._publications.values(),
            *self._subscriptions.values(),
        ]
        return [stats for topic in topics for stats in topic.stats()]

    # -- the slave API -------------------------------------------------------------------------------------

    def publications(self) -> list[list[str]]:
        return [[name, publication.type.name] for name, publication in list(self._publications.items())]

    def subscriptions(self) -> list[list[str]]:
        return [[name, sub.present_type.name] for name, sub in list(self._subscriptions.items())]

    def is_published(self, topic: str) -> bool:
        return topic in self._publications

    def request_datagrams(self, topic: str, request: DatagramRequest) -> list[object]:
        publication = self._publications.get(topic)
        return (
            []
            if publication is None
            else datagram_link.accept(publication, request, links=len(self.datagram_links()))
        )

    def update_publishers(self, topic: str, uris: list[str]) -> None:
        subscription = self._subscriptions.get(topic)
        if subscription is not None:
            subscription.update_publishers(uris)

    def verify_publishers(self, topic: str) -> None:
        subscription = self._subscriptions.get(topic)
        if subscription is not None:
            subscription.nudge()
            self._context.check_publishers(subscription, True)

    def bus_info(self) -> list[list[object]]:
        """[connectionId, destinationId, direction, transport, topic, connected, text] for each link."""
        return [
            *(
                _bus_row(link.id, link.caller_id, link.stats())
                for publication in list(self._publications.values())
                for link in publication.all_links
            ),
            *(
                _bus_row(link.id, link.uri, link.stats())
                for subscription in list(self._subscriptions.values())
                for link in list(subscription.links.values())
            ),
        ]

    def bus_stats(self) -> list[list[object]]:
        """[publishStats, subscribeStats, serviceStats], as in the wiki (rospy adds a column)."""
        publish: list[object] = [
            [
                name,
                _int32(publication.bytes_sent),
                [
                    [link.id, _int32(stats.bytes), _int32(stats.messages), stats.connected]
                    for link in publication.all_links
                    for stats in [link.stats()]
                ],
            ]
            for name, publication in list(self._publications.items())
        ]
        subscribe: list[object] = [
            [
                name,
                [
                    [link.id, _int32(stats.bytes), -1, stats.connected]
                    for link in list(subscription.links.values())
                    for stats in [link.stats()]
                ],
            ]
            for name, subscription in list(self._subscriptions.items())
        ]
        return [publish, subscribe, []]


def _close_publishers(publication: Publication) -> None:
    """Close the handles after a failed registration."""
    for publisher in publication.handles:
        publisher.close()


def _bus_row(id: int, destination: str, stats: LinkStats) -> list[object]:
    direction = "o" if stats.direction == "out" else "i"
    text = f"{stats.transport} connection to [{stats.address}], {stats.state}"
    return [id, destination, direction, stats.transport, stats.topic, stats.connected, text]


def _int32(count: int) -> int:
    """Limit a counter to the 32 bits of an XML-RPC integer."""
    return min(count, 0x7FFFFFFF)
