"""`FoxgloveSession`: one viewer: its channels, subscriptions, parameters and calls.

Messages of the viewer arrive in the server's loop, which must not wait. Work that waits for the robot is
queued and done in order in a thread; so a velocity on an open topic never waits for a master that does not
answer. Messages of topics arrive in the node's threads, changes of the graph in that of `GraphWatch`.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from functools import partial
from typing import Any, Protocol

from rosproto.errors import RosError
from rosproto.gateway.access import Refused
from rosproto.gateway.chunks import framed
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.foxglove import messages
from rosproto.gateway.foxglove.advertised_channels import AdvertisedChannel, AdvertisedService
from rosproto.gateway.foxglove.assets import AssetAnswer
from rosproto.gateway.foxglove.client_publish import ClientPublisher
from rosproto.gateway.foxglove.graph import ConnectionGraph, GraphView, connection_graph
from rosproto.gateway.foxglove.messages import Level
from rosproto.gateway.foxglove.parameters import ViewerParameters
from rosproto.gateway.foxglove.server_state import ClientFacts, ServerState
from rosproto.gateway.foxglove.services import call
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.json_text import is_short
from rosproto.logs import get_logger
from rosproto.worker_pool import WorkerPool

_log = get_logger("rosproto.gateway")

REPEAT_SECONDS = 5.0  # seconds until the same status is sent again
MAX_WAITING = 8  # queued requests of a client; with more, its next message is not read yet
ASSET_SIZE = 64 << 10  # a file counts as this many bytes in the outbox, until it is read


class FoxgloveSession:
    """One viewer of a server; a `ClientSession`.

    Args:
        state: Shared by all sessions.
        channel: Sends to the viewer.

    """

    def __init__(self, state: ServerState, channel: ClientChannel) -> None:
        self.channel = channel
        self._since = time.time()
        self._state = state
        self._closed = False
        self._lock = threading.RLock()
        self._status_times: dict[str, float] = {}
        self._worker = WorkerPool(f"rosproto:foxglove {channel.peer}", 1, daemon=True)
        self._requests: set[Future[None]] = set()  # that wait for the robot, and the one under way
        self._publishing = ClientPublisher(state, self, self._put)
        self._channels: dict[str, AdvertisedChannel] = {}
        self._services: dict[str, AdvertisedService] = {}
        self._subscriptions: dict[int, _Subscription] = {}
        self._free_calls = threading.Semaphore(state.limits.calls_per_client)
        self._graph: ConnectionGraph | None = None  # as sent last; None while it is not wanted
        self._parameters = ViewerParameters(state, self._parameters_changed)
        self._perform: dict[type, Callable[[Any], None]] = {
            messages.Subscribe: self._subscribe,
            messages.Unsubscribe: self._unsubscribe,
            messages.GetParameters: self._get_parameters,
            messages.SetParameters: self._set_parameters,
            messages.FollowParameters: self._follow_parameters,
            messages.LeaveParameters: lambda asked: self._parameters.leave(asked.names),
            messages.WantGraph: self._want_graph,
        }
        self._to_close: list[Closable] = []
        self._send(messages.server_info(state.name, state.capabilities(), state.run))
        first = state.add(self)
        self._put(lambda: state.welcome(self, first))

    @property
    def topics(self) -> tuple[str, ...]:
        """Its subscribed topics."""
        with self._lock:
            return tuple(sorted(one.topic for one in self._subscriptions.values() if one.shared is not None))

    def facts(self) -> ClientFacts:
        """The facts about it now."""
        channel = self.channel
        return ClientFacts(
            channel.peer,
            self.topics,
            channel.sent,
            channel.sent_bytes,
            {key: count for key, count in channel.outbox.dropped.items() if isinstance(key, str)},
            self._publishing.published,
            self._since,
        )

    def _send(self, *payloads: str | bytes) -> None:
        self.channel.answer(payloads)

    # -- messages of the viewer -----------------------------------------------------------------------------

    @property
    def max_message_bytes(self) -> int:
        """Longest next message in bytes."""
        return self._state.max_message_bytes

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
            await state.pool.run(partial(self._publishing.publish, asked, time.monotonic()))
        elif isinstance(asked, messages.Call):
            self._call(asked)
        elif isinstance(asked, messages.FetchAsset):
            self._fetch(asked)
        elif isinstance(asked, messages.Advertise):
            self._publishing.advertise(asked)
        elif isinstance(asked, messages.Unadvertise):
            self._publishing.unadvertise(asked)
        else:
            self._put(partial(self._perform[type(asked)], asked))
        while len(self._requests) > MAX_WAITING:
            waiting = [asyncio.wrap_future(task) for task in tuple(self._requests)]
            await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)

    def _put(self, work: Callable[[], object]) -> None:
        """Do work that may wait for the robot, in order, in a thread. Never waits; dropped after the end."""
        if not self._closed:
            task = self._worker.add(partial(_logged, work))
            self._requests.add(task)
            task.add_done_callback(self._requests.discard)

    # -- channels and services ------------------------------------------------------------------------------

    def show(self, view: GraphView) -> None:
        """Advertise exactly the topics and services of a view; may probe publishers."""
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
                self._send_graph(self._graph, now)
        self.show_services(view)

    def _withdraw(self, channels: Iterable[AdvertisedChannel]) -> None:
        """Withdraw channels, and end their subscriptions. The lock is held."""
        gone = {one.id for one in channels}
        if not gone:
            return
        self._channels = {topic: one for topic, one in self._channels.items() if one.id not in gone}
        for id in [id for id, one in self._subscriptions.items() if one.channel.id in gone]:
            self._end_subscription(id)
        self._send(messages.unadvertise(sorted(gone)))

    def show_services(self, view: GraphView) -> None:
        """Advertise exactly the services of a view whose type is known."""
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
        """The master was restarted: withdraw everything, with a new session id."""
        with self._lock:
            if self._closed:
                return
            self._withdraw(list(self._channels.values()))
            self._services = {}
            if self._graph is not None:
                self._graph = ConnectionGraph()
            self._send(messages.server_info(self._state.name, self._state.capabilities(), self._state.run))

    def status(self, text: str, level: Level = Level.WARNING, id: str | None = None) -> None:
        """Send a status; the same text only once in `REPEAT_SECONDS`."""
        now = time.monotonic()
        with self._lock:
            if self._closed or now - self._status_times.get(text, -REPEAT_SECONDS) < REPEAT_SECONDS:
                return
            if len(self._status_times) > 100:
                self._status_times.clear()
            self._status_times[text] = now
            self._send(messages.status(text, level, id))

    def remove_status(self, id: str) -> None:
        """Remove the status with this id."""
        with self._lock:
            self._status_times.clear()
            self._send(messages.remove_status(id))

    def tell_time(self, nanoseconds: int) -> None:
        """Send the simulated time; it replaces one that waits."""
        data = messages.time(nanoseconds)
        self.channel.outbox.put(messages.time, len(data), data, keep=1)

    def _want_graph(self, asked: messages.WantGraph) -> None:
        with self._lock:
            if not asked.wanted:
                self._graph = None
            elif self._graph is None:
                now = connection_graph(self._state.view, self._state.access)
                self._send_graph(ConnectionGraph(), now)

    def _send_graph(self, before: ConnectionGraph, now: ConnectionGraph) -> None:
        """The lock is held."""
        self._send(messages.graph_update(before, now))
        self._graph = now

    # -- subscriptions --------------------------------------------------------------------------------------

    def _subscribe(self, asked: messages.Subscribe) -> None:
        for id, channel in asked.subscriptions:
            try:
                self._subscribe_one(id, channel)
            except (Refused, RosError, ValueError) as problem:
                self.status(str(problem))

    def _subscribe_one(self, id: int, number: int) -> None:
        limit = self._state.limits.subscriptions_per_client
        with self._lock:
            if self._closed:
                return
            channel = next((one for one in self._channels.values() if one.id == number), None)
            if channel is None:
                raise Refused(f"channel {number} is not advertised, or no longer")
            if id in self._subscriptions:
                raise Refused(f"{channel.topic} is not subscribed to: subscription {id} is in use")
            if any(one.channel.id == number for one in self._subscriptions.values()):
                raise Refused(f"{channel.topic} is already subscribed to")
            if len(self._subscriptions) >= limit:
                raise Refused(
                    f"{channel.topic} is not subscribed to: {limit} topics already are, which is the limit"
                )
            made = self._subscriptions[id] = _Subscription(id, channel, self.channel, self._differs)
        try:
            shared = self._state.subscribe(channel.topic, made)
        except BaseException as problem:
            with self._lock:
                self._end_subscription(id, made)
            if isinstance(problem, (RosError, ValueError)):
                raise Refused(f"{channel.topic} is not subscribed to: {problem}") from problem
            raise
        with self._lock:
            kept = self._subscriptions.get(id) is made
            if kept:
                made.shared = shared
        if not kept:
            shared.close()

    def _differs(self, channel: AdvertisedChannel, description: TopicDescription) -> None:
        """A message is not of its channel's schema, so the viewer would misread it. In a node's thread."""
        if description.type_name == channel.schema.type_name and self._state.differs(description):
            return  # another channel replaces this one
        self.status(
            f"messages of {channel.topic} are not sent: a publisher sends {description.type_name[:200]} "
            f"({description.md5sum}), the channel has {channel.schema.type_name} ({channel.schema.md5sum})"
        )

    def _unsubscribe(self, asked: messages.Unsubscribe) -> None:
        with self._lock:
            for id in asked.subscriptions:
                self._end_subscription(id)

    def _end_subscription(self, id: int, only: _Subscription | None = None) -> None:
        """The lock is held; the topic is closed later, because that calls the master."""
        subscription = self._subscriptions.get(id)
        if subscription is None or only not in (None, subscription):
            return
        del self._subscriptions[id]
        subscription.ended = True
        self.channel.outbox.forget(subscription.topic)
        if subscription.shared is not None:
            self._to_close.append(subscription.shared)
            self._put(self._close_left)

    def _close_left(self) -> None:
        with self._lock:
            to_close, self._to_close = self._to_close, []
        for shared in to_close:
            shared.close()

    # -- calls, files and parameters ------------------------------------------------------------------------

    def _call(self, asked: messages.Call) -> None:
        """Call a service in a thread, if not too many calls wait."""
        state = self._state
        with self._lock:
            service = next((one for one in self._services.values() if one.id == asked.service), None)
        if service is None:
            problem = f"service {asked.service} is not advertised, or no longer"
        elif not self._free_calls.acquire(blocking=False):
            limit = state.limits.calls_per_client
            problem = f"{limit} calls of this client wait for their answers, which is the limit"
        else:
            state.pool.spawn(partial(self._wait_for_answer, service, asked))
            return
        self._send(messages.service_failure(asked, problem))

    def _wait_for_answer(self, service: AdvertisedService, asked: messages.Call) -> None:
        state = self._state
        answer: str | bytes
        try:
            with state.waiting():
                answer = messages.service_response(asked, call(service, asked, state))
        except (Refused, RosError) as problem:
            answer = messages.service_failure(asked, str(problem))
        except Exception as problem:
            answer = messages.service_failure(asked, f"an error of the gateway ({type(problem).__name__})")
            _log.exception("! foxglove: a call of %s for %s", service.name, self.channel.peer)
        finally:
            self._free_calls.release()
        self._send(answer)

    def _fetch(self, asked: messages.FetchAsset) -> None:
        assets = self._state.assets
        if not assets:
            self._send(messages.asset_failure(asked.request, "no files are given here (--assets)"))
        else:
            self.channel.answer_deferred(ASSET_SIZE, AssetAnswer(assets, asked))

    def _get_parameters(self, asked: messages.GetParameters) -> None:
        try:
            found = self._parameters.get(asked.names)
        except RosError as problem:
            self.status(f"parameters cannot be read: {problem}")
            found = {}
        self._send(messages.parameter_values(found.items(), asked.id))

    def _set_parameters(self, asked: messages.SetParameters) -> None:
        state = self._state
        for name, value in asked.parameters[: state.limits.subscriptions_per_client]:
            problem = self._parameters.set(name, value)
            if problem is not None:
                state.refusals += 1
                self.status(problem)
        if asked.id is not None:  # answer with the present values
            names = [name for name, _ in asked.parameters]
            try:
                found = self._parameters.get(names) if names else {}
            except RosError:
                found = {}
            values = [(name, found[name]) for name in names if name in found]
            self._send(messages.parameter_values(values, asked.id))

    def _follow_parameters(self, asked: messages.FollowParameters) -> None:
        problem = self._parameters.follow(asked.names)
        if problem is not None:
            self.status(problem)

    def _parameters_changed(self, parameters: list[tuple[str, object]]) -> None:
        if not self._closed:
            self._send(messages.parameter_values(parameters))

    # -- the end --------------------------------------------------------------------------------------------

    def ended(self) -> None:
        """The viewer has gone: send zero where it drove, then close everything. May wait for the master."""
        with self._lock:
            self._closed = True
            for id in tuple(self._subscriptions):
                self._end_subscription(id)
        self._state.publications.velocity_watchdog.gone(self)
        for task in tuple(self._requests):
            task.cancel()  # the one under way continues
        self._publishing.close()
        self._close_left()
        self._parameters.close()
        self._state.gone(self)

    def __repr__(self) -> str:
        return f"<Session of {self.channel.peer}, {len(self.topics)} topics>"


class Closable(Protocol):
    def close(self) -> None: ...


class _Subscription:
    """The viewer's subscription of a channel; receives its topic's messages.

    Attributes:
        shared: The subscription at the robot; None until it is open.
        ended: The viewer has unsubscribed.
    """

    def __init__(
        self,
        id: int,
        channel: AdvertisedChannel,
        viewer: ClientChannel,
        differs: Callable[[AdvertisedChannel, TopicDescription], None],
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
        """Send a message to the viewer; see `Receiver`."""
        description = event.description
        if self.ended:
            return
        if description is not self._same:
            schema = self.channel.schema
            if (description.md5sum, description.type_name) != (schema.md5sum, schema.type_name):
                self._differs(self.channel, description)
                return
            self._same = description
        head = messages.message_head(self._id, event.stamp.to_nsec())
        self._viewer.outbox.put(self.topic, len(event.data), framed(head, event.data))


def _logged(work: Callable[[], object]) -> None:
    try:
        work()
    except Exception:
        _log.exception("! foxglove: a request of a viewer failed")
