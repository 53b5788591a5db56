"""A link between a publisher and a subscriber in one process: encoded bytes are passed without a socket.

Bytes are passed, not the object, since the publisher may change its message afterwards. The subscriber
decodes the publisher's bytes (immutable, shared by all links) without a copy, so arrays are read-only views.
As over TCP, the md5sums must agree, and each subscriber has its own queue (the oldest message is dropped),
which a shared thread empties, so publish() never waits.
"""

from __future__ import annotations

import itertools
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, MasterError, RosTimeout
from rosproto.node.incoming.publisher_link import PublisherLink
from rosproto.node.incoming.publisher_link_state import LinkEvent
from rosproto.node.outgoing.frames import LargeFrame
from rosproto.node.outgoing.publication import Publication
from rosproto.node.stats import LinkStats
from rosproto.protocol.handshake import check_publisher_header, check_subscriber_header, subscriber_header
from rosproto.transport.shared_threads import shared_threads

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

MAX_AT_ONCE = 256
IN_FLIGHT = 1 << 20  # bytes that may wait regardless of the queue size, as in the buffers of TCP


class _LocalPipe:
    """The publisher's side: an `OutgoingLink` that a shared thread empties."""

    transport = "INTRAPROCESS"

    def __init__(self, link: LocalLink, publication: Publication, queue_size: int, id: int) -> None:
        self.caller_id = link.subscription.context.name
        self.address = link.subscription.context.uri
        self.id = id
        self.queue_size = queue_size
        self._told_as = link.transport
        self._publication = publication
        self._condition = threading.Condition(threading.Lock())
        self._frames: deque[bytes] = deque()
        self._link = link
        self._at_work = True  # a thread empties it, or will; the one that begins the session, at first
        self._under_way = 0
        self._bytes = 0
        self._messages = 0
        self._dropped = 0
        self._closed = False
        asked = link.subscription.present_type
        self.wanted = None if asked.is_wildcard else asked.message_class  # the class that it decodes

    def start(self) -> None:
        """No effect: the session has begun."""

    def set_linger(self, linger: bool) -> None:
        """No effect: no bytes outlive the process."""

    def send(self, frame: bytes) -> None:
        with self._condition:
            if self._closed:
                return
            self._frames.append(frame)
            self._messages += 1
            self._bytes += len(frame)
            self._under_way += len(frame)
            while len(self._frames) > self.queue_size and self._under_way > IN_FLIGHT:
                self._under_way -= len(self._frames.popleft())
                self._dropped += 1
            begin, self._at_work = not self._at_work, True
        if begin:
            self.begin_work()

    def begin_work(self) -> None:
        """Have a shared thread empty it."""
        try:
            shared_threads().add(self._link.work)
        except RuntimeError:  # the process has no thread left: the next message tries again
            with self._condition:
                self._at_work = False

    def rest(self) -> bool:
        """The thread has done its part; False if there is more to do, for another thread."""
        with self._condition:
            self._at_work = bool(self._frames) or self._closed
            return not self._at_work

    def send_soon(self, frame: bytes, now: float) -> bool:
        self.send(frame)
        return False

    def send_large(self, frame: LargeFrame) -> None:
        self.send(frame.owned())

    def take(self) -> list[bytes]:
        """Some frames; [] when there are none.

        Raises:
            ConnectionLost: There are none, and the link is closed.
        """
        with self._condition:
            frames = list(itertools.islice(self._frames, MAX_AT_ONCE))
            for frame in frames:
                self._frames.popleft()
                self._under_way -= len(frame)
            if not self._frames:
                self._condition.notify_all()
            if self._closed and not frames:
                raise ConnectionLost(
                    f"{self._publication.name}: the publisher {self._link.caller_id} was closed",
                    peer=self._link.uri,
                )
            return frames

    def has_arrived(self) -> bool:
        """True: the subscriber has a sent message at once."""
        return True

    def wait_empty(self, timeout: float) -> None:
        with self._condition:
            if not self._condition.wait_for(lambda: self._closed or not self._frames, timeout):
                raise RosTimeout(
                    f"{self._publication.name}: {self.caller_id} has not received all messages",
                    seconds=timeout,
                )

    def end_sending(self) -> bool:
        return False  # `wait_empty` has waited for the subscriber

    def close(self, *, deliver: bool = True) -> None:
        # Detach before a shared thread sees the end and detaches: on_disconnect runs in the closing thread.
        try:
            self._publication.detach(self)
        finally:
            with self._condition:
                self._closed = True
                self._condition.notify_all()
                begin, self._at_work = not self._at_work, True
            if begin:
                self.begin_work()

    def stats(self) -> LinkStats:

        return LinkStats(
            topic=self._publication.name,
            direction="out",
            peer=self.caller_id,
            address=self.address,
            transport=self._told_as,
            connected=not self._closed,
            bytes=self._bytes,
            messages=self._messages,
            dropped=self._dropped,
            queued=len(self._frames),
            state="closed" if self._closed else "connected",
        )


class LocalLink(PublisherLink):
    """The subscriber's side; see `PublisherLink`."""

    def __init__(self, subscription: Subscription, uri: str, id: int) -> None:
        super().__init__(subscription, uri, id)
        nodes = self._context.local_nodes
        self.transport = "INTRAPROCESS" if nodes is None else nodes.told_as
        self._pipe: _LocalPipe | None = None

    def _open(self) -> None:
        publication = self._find_publication()
        self._step(LinkEvent.ADDRESS)
        header = publication.header()
        wanted, offered = self.subscription.type, publication.type
        if wanted.name == offered.name and not wanted.is_wildcard:
            wanted = offered  # perhaps another revision: request the publisher's, and convert its values
        request = subscriber_header(
            topic=self.topic, type_name=wanted.name, md5sum=wanted.md5sum, callerid=self._context.name
        )
        check_subscriber_header(
            request,
            topic=self.topic,
            type_name=offered.name,
            md5sum=offered.md5sum,
            peer=self._context.uri,
        )
        reply = check_publisher_header(
            header, topic=self.topic, type_name=wanted.name, md5sum=wanted.md5sum, peer=self.uri
        )
        self._revised = self.subscription.learn(reply, self.uri)
        self.header = header
        self.caller_id = reply.callerid
        self._pipe = _LocalPipe(self, publication, publication.queue_size, self._context.next_link_id())
        if not self.closed:
            publication.prepare()  # before the publisher sees the subscriber and publishes
            publication.attach(self._pipe, self.address)

    def _find_publication(self) -> Publication:
        nodes = self._context.local_nodes
        find = None if nodes is None else nodes.find(self.uri)
        if find is None:
            raise ConnectionLost(
                f"{self.topic}: the node {self.uri} of this process is closed", peer=self.uri
            )
        publication: Publication | None = find(self.topic)
        if publication is None:
            raise MasterError("requestTopic", -1, f"Not a publisher of [{self.topic}]", uri=self.uri)
        return publication

    def _begin(self, event: LinkEvent) -> None:
        shared_threads().add(partial(self._run, event))

    def _hold_session(self) -> bool:
        return self._begin_session()

    def _work(self, part: Callable[[], bool]) -> bool:
        goes_on, pipe = super()._work(part), self._pipe
        if goes_on and pipe is not None and not pipe.rest():
            pipe.begin_work()
        return goes_on

    def work(self) -> None:
        """Deliver what has come, in a shared thread, one at a time."""
        self._work(self._deliver)

    def _deliver(self) -> bool:
        pipe, subscription = self._pipe, self.subscription
        assert pipe is not None
        frames = pipe.take()
        if frames:
            revised = self._revised
            delivery = subscription.delivery if revised is None else subscription.delivery_for(revised)
            self._messages += len(frames)
            self._bytes += sum(map(len, frames))
            if delivery.newest is not None and len(frames) > delivery.newest:
                subscription.skipped += len(frames) - delivery.newest
                frames = frames[-delivery.newest :]
            batch = [delivery.decode(frame, 4, len(frame)) for frame in frames]
            subscription.hand_out(self, delivery, batch, self.header, revised)
        return True

    def _interrupt(self) -> None:
        pipe = self._pipe
        if pipe is not None:
            pipe.close()

    def _end_session(self) -> None:
        pipe, self._pipe = self._pipe, None
        if pipe is not None:
            pipe.close()
        super()._end_session()
