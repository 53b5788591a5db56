"""One viewer: what it is offered, follows, publishes and asks for.

Its messages come one after the other, in the server's loop, which must not wait. What waits for the robot
goes into a queue and is done in its order in a thread, so that a velocity on a topic that is open already
never waits for a master that does not answer. Messages of topics come in the node's threads, changes of the
graph in that of its watch.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Protocol

from rosproto.aio.pool import Pool
from rosproto.errors import RosError
from rosproto.gateway.access import Refused
from rosproto.gateway.chunks import framed
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.client_limits import READER_BYTES
from rosproto.gateway.foxglove import messages
from rosproto.gateway.foxglove.advertised_channels import AdvertisedChannel, AdvertisedService
from rosproto.gateway.foxglove.assets import AssetAnswer
from rosproto.gateway.foxglove.client_publish import ClientPublisher
from rosproto.gateway.foxglove.graph import ConnectionGraph, GraphView, connection_graph
from rosproto.gateway.foxglove.messages import Level
from rosproto.gateway.foxglove.parameters import FollowedParameters
from rosproto.gateway.foxglove.server_state import ServerState
from rosproto.gateway.foxglove.services import CallCount, call
from rosproto.gateway.json_text import is_short
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.logs import get_logger

_log = get_logger("rosproto.gateway")

TOLD_AGAIN = 5.0  # seconds for which the same text is not told again
MOST_WAITING = 8  # requests of a client that wait for the robot, before its next message is read
ASSET_SIZE = 64 << 10  # bytes for which a file counts while it waits to be read and sent


class FoxgloveSession:
    """One viewer of a server; see `gateway.channel.FoxgloveSession`.

    Args:
        state: What all sessions share.
        channel: The way to the viewer.

    Attributes:
        since: When it came, seconds since 1970.
    """

    def __init__(self, state: ServerState, channel: ClientChannel) -> None:
        self.channel = channel
        self.since = time.time()
        self._state = state
        self._closed = False
        self._lock = threading.RLock()
        self._told: dict[str, float] = {}
        self._queue = _Queue(state.pool)
        self._publishing = ClientPublisher(state.client_topics, self, self._queue.put)
        self._channels: dict[str, AdvertisedChannel] = {}
        self._services: dict[str, AdvertisedService] = {}
        self._subscriptions: dict[int, _Subscription] = {}
        self._calls = CallCount(state.limits.calls_per_client, "this client")
        self._graph: ConnectionGraph | None = None  # as it was told; None while it is not wanted
        self._followed = FollowedParameters(
            state.node, state.access, state.limits.subscriptions_per_client, self._parameters_changed
        )
        self._perform: dict[type, Callable[[Any], None]] = {
            messages.Subscribe: self._subscribe,
            messages.Unsubscribe: self._unsubscribe,
            messages.GetParameters: self._get_parameters,
            messages.SetParameters: self._set_parameters,
            messages.FollowParameters: self._follow_parameters,
            messages.LeaveParameters: lambda asked: self._followed.leave(asked.names),
            messages.WantGraph: self._want_graph,
        }
        self._leaving: list[Closable] = []
        self._send(messages.server_info(state.name, state.capabilities(), state.run))
        first = state.add(self)
        self._queue.put(lambda: state.welcome(self, first))

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics that it follows now."""
        with self._lock:
            return tuple(sorted(one.topic for one in self._subscriptions.values() if one.shared is not None))

    @property
    def dropped(self) -> dict[str, int]:
        """Messages that were not sent because it did not read, by topic."""
        return {key: count for key, count in self.channel.outbox.dropped.items() if isinstance(key, str)}

    @property
    def published(self) -> int:
        """Messages that it has published."""
        return self._publishing.published

    def _send(self, *payloads: str | bytes) -> None:
        self.channel.answer(payloads)

    # -- what comes -----------------------------------------------------------------------------------------

    @property
    def longest(self) -> int:
        """Bytes that its next message may have: what could not be carried out need not be read."""
        limits = self._state.limits
        if not self._state.access.writes_anything:
            return min(READER_BYTES, limits.message_bytes)
        return limits.message_bytes

    async def received(self, data: str | bytes) -> None:
        """Carry out one message; in the server's loop."""
        state = self._state
        try:
            if isinstance(data, bytes) or is_short(data):
                asked = messages.read(data, state.json)
            else:
                asked = await state.pool.run(partial(messages.read, data, state.json))
        except messages.MessageError as problem:
            self.status(str(problem), Level.ERROR)
            return
        if isinstance(asked, messages.Publish):
            if self._publishing.publish_at_once(asked):
                return
            await state.pool.run(partial(self._publishing.publish, asked))
        elif isinstance(asked, messages.Call):
            self._call(asked)
        elif isinstance(asked, messages.FetchAsset):
            self._fetch(asked)
        elif isinstance(asked, messages.Advertise):
            self._publishing.advertise(asked)
        elif isinstance(asked, messages.Unadvertise):
            self._publishing.unadvertise(asked)
        else:
            self._queue.put(partial(self._perform[type(asked)], asked))
        if self._queue.full:
            await state.pool.run(self._queue.wait_for_room)

    # -- what is offered ------------------------------------------------------------------------------------

    def show(self, view: GraphView) -> None:
        """Offer exactly the topics and services of a view; may ask publishers."""
        wanted = self._state.advertised.channels(view)
        with self._lock:
            if self._closed:
                return
            self._withdraw([one for topic, one in self._channels.items() if wanted.get(topic) != one])
            new = [one for topic, one in wanted.items() if topic not in self._channels]
            if new:
                self._channels.update((one.topic, one) for one in new)
                self._send(messages.advertise(new))
            if self._graph is not None and (now := connection_graph(view, self._state.access)) != self._graph:
                self._tell_graph(self._graph, now)
        self.show_services(view)

    def _withdraw(self, channels: Iterable[AdvertisedChannel]) -> None:
        """Take back channels, and end what subscribes them. The lock is held."""
        gone = {one.id for one in channels}
        if not gone:
            return
        self._channels = {topic: one for topic, one in self._channels.items() if one.id not in gone}
        for id in [id for id, one in self._subscriptions.items() if one.channel.id in gone]:
            self._end_subscription(id)
        self._send(messages.unadvertise(sorted(gone)))

    def show_services(self, view: GraphView) -> None:
        """Offer exactly the services of a view whose type is known."""
        wanted = self._state.advertised_services(view)
        with self._lock:
            if self._closed:
                return
            gone = [one.id for name, one in self._services.items() if wanted.get(name) != one]
            new = [one for name, one in wanted.items() if self._services.get(name) != one]
            self._services = dict(wanted)
            if gone:
                self._send(messages.unadvertise_services(gone))
            if new:
                self._send(messages.advertise_services(new))

    def restart(self) -> None:
        """The master is another run: the viewer forgets everything that it was offered."""
        with self._lock:
            if self._closed:
                return
            self._withdraw(list(self._channels.values()))
            self._services = {}
            if self._graph is not None:
                self._graph = ConnectionGraph()
            self._send(messages.server_info(self._state.name, self._state.capabilities(), self._state.run))

    def status(self, text: str, level: Level = Level.WARNING, id: str | None = None) -> None:
        """Show the viewer a text; the same text only once in a while."""
        now = time.monotonic()
        with self._lock:
            if self._closed or now - self._told.get(text, -TOLD_AGAIN) < TOLD_AGAIN:
                return
            if len(self._told) > 100:
                self._told.clear()
            self._told[text] = now
            self._send(messages.status(text, level, id))

    def remove_status(self, id: str) -> None:
        """The status with this id no longer holds."""
        with self._lock:
            self._told.clear()
            self._send(messages.remove_status(id))

    def tell_time(self, nanoseconds: int) -> None:
        """The simulated time; what it has not taken is of no use any more."""
        data = messages.time(nanoseconds)
        self.channel.offer(messages.time, len(data), data, keep=1)

    def _want_graph(self, asked: messages.WantGraph) -> None:
        with self._lock:
            if not asked.wanted:
                self._graph = None
            elif self._graph is None:
                now = connection_graph(self._state.view, self._state.access)
                self._tell_graph(ConnectionGraph(), now)

    def _tell_graph(self, before: ConnectionGraph, now: ConnectionGraph) -> None:
        """The lock is held."""
        self._send(messages.graph_update(before, now))
        self._graph = now

    # -- topics that it follows -----------------------------------------------------------------------------

    def _subscribe(self, asked: messages.Subscribe) -> None:
        for id, channel in asked.subscriptions:
            try:
                self._subscribe_one(id, channel)
            except (Refused, RosError, ValueError) as problem:
                self.status(str(problem))

    def _subscribe_one(self, id: int, number: int) -> None:
        most = self._state.limits.subscriptions_per_client
        with self._lock:
            if self._closed:
                return
            channel = next((one for one in self._channels.values() if one.id == number), None)
            if channel is None:
                raise Refused(f"channel {number} is not offered, or not any more")
            if id in self._subscriptions:
                raise Refused(f"{channel.topic} is not followed: subscription {id} is in use")
            if any(one.channel.id == number for one in self._subscriptions.values()):
                raise Refused(f"{channel.topic} is followed already")
            if len(self._subscriptions) >= most:
                raise Refused(f"{channel.topic} is not followed: {most} topics are followed, no more can be")
            made = self._subscriptions[id] = _Subscription(id, channel, self.channel, self._state.differs)
        try:
            shared = self._state.subscribe(channel.topic, made)
        except BaseException as problem:
            with self._lock:
                self._end_subscription(id, made)
            if isinstance(problem, (RosError, ValueError)):
                raise Refused(f"{channel.topic} is not followed: {problem}") from problem
            raise
        with self._lock:
            kept = self._subscriptions.get(id) is made
            if kept:
                made.shared = shared
        if not kept:
            shared.close()

    def _unsubscribe(self, asked: messages.Unsubscribe) -> None:
        with self._lock:
            for id in asked.subscriptions:
                self._end_subscription(id)

    def _end_subscription(self, id: int, only: _Subscription | None = None) -> None:
        """The lock is held; the topic is left later, as that asks the master."""
        subscription = self._subscriptions.get(id)
        if subscription is None or only not in (None, subscription):
            return
        del self._subscriptions[id]
        subscription.ended = True
        self.channel.outbox.forget(subscription.topic)
        if subscription.shared is not None:
            self._leaving.append(subscription.shared)
            self._queue.put(self._leave)

    def _leave(self) -> None:
        with self._lock:
            leaving, self._leaving = self._leaving, []
        for shared in leaving:
            shared.close()

    # -- what it asks for -----------------------------------------------------------------------------------

    def _call(self, asked: messages.Call) -> None:
        """Call a service in a thread of its own, if not too many wait."""
        state = self._state
        with self._lock:
            service = next((one for one in self._services.values() if one.id == asked.service), None)
        try:
            if service is None:
                raise Refused(f"service {asked.service} is not offered, or not any more")
            self._calls.begin()
            try:
                state.calls.begin()
            except Refused:
                self._calls.end()
                raise
        except Refused as problem:
            self._send(messages.service_failure(asked, str(problem)))
        else:
            state.pool.spawn(partial(self._wait_for_answer, service, asked))

    def _wait_for_answer(self, service: AdvertisedService, asked: messages.Call) -> None:
        state = self._state
        answer: str | bytes
        try:
            data = call(service, asked, state.node, state.access, state.limits)
            answer = messages.service_response(asked, data)
        except (Refused, RosError) as problem:
            answer = messages.service_failure(asked, str(problem))
        except Exception as problem:
            answer = messages.service_failure(asked, f"an error of the gateway ({type(problem).__name__})")
            _log.exception("! foxglove: a call of %s for %s", service.name, self.channel.peer)
        finally:
            self._calls.end()
            state.calls.end()
        self._send(answer)

    def _fetch(self, asked: messages.FetchAsset) -> None:
        assets = self._state.assets
        if not assets:
            self._send(messages.asset_failure(asked.request, "no files are given here (--assets)"))
        else:
            self.channel.answer_deferred(ASSET_SIZE, AssetAnswer(assets, asked))

    def _get_parameters(self, asked: messages.GetParameters) -> None:
        try:
            found = self._state.parameters.get(asked.names)
        except RosError as problem:
            self.status(f"parameters cannot be told: {problem}")
            found = {}
        self._send(messages.parameter_values(found.items(), asked.id))

    def _set_parameters(self, asked: messages.SetParameters) -> None:
        state = self._state
        for name, value in asked.parameters[: state.limits.subscriptions_per_client]:
            problem = state.parameters.set(name, value)
            if problem is not None:
                state.client_topics.refusals += 1
                self.status(problem)
        if asked.id is not None:  # the values that hold now
            names = [name for name, _ in asked.parameters]
            try:
                found = state.parameters.get(names) if names else {}
            except RosError:
                found = {}
            values = [(name, found[name]) for name in names if name in found]
            self._send(messages.parameter_values(values, asked.id))

    def _follow_parameters(self, asked: messages.FollowParameters) -> None:
        problem = self._followed.follow(asked.names)
        if problem is not None:
            self.status(problem)

    def _parameters_changed(self, parameters: list[tuple[str, object]]) -> None:
        if not self._closed:
            self._send(messages.parameter_values(parameters))

    # -- the end --------------------------------------------------------------------------------------------

    def ended(self) -> None:
        """It has gone: zero where it drove, then leave everything. May wait for the master."""
        with self._lock:
            self._closed = True
            for id in tuple(self._subscriptions):
                self._end_subscription(id)
        self._state.publications.velocity_watchdog.gone(self)
        self._queue.close()
        self._publishing.close()
        self._leave()
        self._followed.close()
        self._state.gone(self)

    def __repr__(self) -> str:
        return f"<Session of {self.channel.peer}, {len(self.topics)} topics>"


class Closable(Protocol):
    def close(self) -> None: ...


class _Subscription:
    """A channel that the viewer follows, which receives its topic's messages.

    Attributes:
        shared: Ends it; None while it begins.
        ended: The viewer wants no more.
    """

    def __init__(
        self,
        id: int,
        channel: AdvertisedChannel,
        viewer: ClientChannel,
        differs: Callable[[TopicDescription], None],
    ) -> None:
        self.channel = channel
        self.topic = channel.topic
        self.shared: Closable | None = None
        self.ended = False
        self._id = id
        self._viewer = viewer
        self._differs = differs
        self._same: TopicDescription | None = None

    def offer(self, event: MessageEvent) -> None:
        """See `Receiver`."""
        description = event.description
        if self.ended:
            return
        if description is not self._same:
            told = self.channel.schema
            if (description.md5sum, description.type_name) != (told.md5sum, told.type_name):
                self._differs(description)
                return  # the viewer would misread it; the channel that replaces this one sends it
            self._same = description
        head = messages.message_head(self._id, event.stamp.to_nsec())
        self._viewer.offer(self.topic, len(event.data), framed(head, event.data))


class _Queue:
    """What one viewer asks of the robot, done one after the other in a thread of the pool."""

    def __init__(self, pool: Pool) -> None:
        self._pool = pool
        self._changed = threading.Condition()
        self._waiting: deque[Callable[[], object]] = deque()
        self._running = self._closed = False

    @property
    def full(self) -> bool:
        """Whether more waits than should be read ahead."""
        return len(self._waiting) >= MOST_WAITING

    def put(self, work: Callable[[], object]) -> None:
        """Never waits."""
        with self._changed:
            if self._closed:
                return
            self._waiting.append(work)
            if self._running:
                return
            self._running = True
        self._pool.spawn(self._run)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.notify_all()
                if not self._waiting:
                    self._running = False
                    return
                work = self._waiting.popleft()
            try:
                work()
            except Exception:
                _log.exception("! foxglove: a request of a viewer failed")

    def wait_for_room(self) -> None:
        """Return when it is not full any more."""
        with self._changed:
            self._changed.wait_for(lambda: not self.full or self._closed)

    def close(self) -> None:
        """Drop what waits; what is being done goes on."""
        with self._changed:
            self._closed = True
            self._waiting.clear()
            self._changed.notify_all()
