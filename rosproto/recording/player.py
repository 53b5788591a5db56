"""Play bags into a live graph: the recorded bytes, at the recorded times, under the recorded names.

`Player.play` runs in the calling thread; `pause`, `step` and `stop` may be called from any other thread, or
from `on_tick`, which is called in the playing thread about 20 times a second.

The delay after advertising, latched messages from before the start, and a clock that keeps ticking while
paused follow rosbag player.cpp, because users rely on them.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice

from rosproto.bag import BagReader, Connection
from rosproto.bag.messages import publishable_class_of
from rosproto.coercion import as_float
from rosproto.errors import BagError, LocalProtocolError, RosTimeout
from rosproto.node import Node, Publisher
from rosproto.recording.pacer import ClockOutput, Pacer, RateControl
from rosproto.recording.timeline import Timeline, TimelineEntry
from rosproto.time import Time

NS = 1_000_000_000
SHORT = 0.01
TICK = 0.05  # seconds between two calls of `on_tick`, and the longest sleep
IMMEDIATE_BATCH = 64


class Player:
    """Publishes the messages of bags. Close it, or use it in a `with` block, to unregister its topics.

    Args:
        node: The node that publishes.
        bags: An open bag, or several that are played as one; the caller closes them.
        topics: Only these (recorded names).
        rate: Speed, relative to that of the recording.
        start: Seconds to skip at the beginning. Messages latched before are published first.
        duration: Play only this many seconds of the bags.
        loop: Begin again at the end.
        clock_hz: Publish the bags' time on /clock this often (in real time); None does not.
        remap: Recorded name -> name to publish under.
        prefix: Prefix for every name.
        delay: Seconds between advertising and the first message, so that subscribers can connect.
        queue_size: The most messages that wait for one slow subscriber.
        keep_alive: Stay after the end until `stop`, so that latched messages remain available.
        paused: Begin paused.
        skip_empty: Skip gaps without messages that are longer than this, s.
        immediate: Do not wait for the recorded times: play as fast as the subscribers can receive.
        pause_topics: Pause before each message on these (recorded names); see `pause_on_topics`.
        rate_control: A topic that shows how far a node has come: its header stamps are bag time, and playing
            waits while it is more than `rate_control_delay` ahead.
        rate_control_delay: Seconds of bag time that playing may be ahead of `rate_control`.
        on_tick: Called from time to time while playing, paused or waiting.
        on_left_out: Called with a sentence for each connection whose messages cannot be published because
            its topic has another definition already; they are left out. None raises a BagError.
        pacer: For tests.

    Raises:
        BagError: A topic is in none of the bags, or two connections have different definitions for one topic
            (see `on_left_out`).
        ValueError: An option is out of range.

    Attributes:
        timeline: The span that is played.
        published: Messages published so far.
        position_ns: The bags' time that has been reached, ns since 1970.
        pause_on_topics: Whether `pause_topics` take effect.
    """

    def __init__(
        self,
        node: Node,
        bags: BagReader | Sequence[BagReader],
        *,
        topics: Iterable[str] | None = None,
        rate: float = 1.0,
        start: float = 0.0,
        duration: float | None = None,
        loop: bool = False,
        clock_hz: float | None = None,
        remap: Mapping[str, str] | None = None,
        prefix: str = "",
        delay: float = 0.0,
        queue_size: int = 1000,
        keep_alive: bool = False,
        paused: bool = False,
        skip_empty: float | None = None,
        immediate: bool = False,
        pause_topics: Iterable[str] = (),
        rate_control: str | None = None,
        rate_control_delay: float = 1.0,
        on_tick: Callable[[Player], object] | None = None,
        on_left_out: Callable[[str], object] | None = None,
        pacer: Pacer | None = None,
    ) -> None:
        rate, delay, rate_control_delay = as_float(rate), as_float(delay), as_float(rate_control_delay)
        clock_hz, skip_empty = as_float(clock_hz), as_float(skip_empty)
        if not rate > 0:
            raise ValueError(f"rate {rate}: it must be greater than 0")
        if clock_hz is not None and not clock_hz > 0:
            raise ValueError(f"clock_hz {clock_hz}: it must be greater than 0")
        bags = [bags] if isinstance(bags, BagReader) else bags
        self.timeline = Timeline(bags, topics=topics, start=as_float(start), duration=as_float(duration))
        self._node = node
        self._rate = rate
        self._loop = loop
        self._remap = dict(remap or {})
        self._prefix = prefix
        self._delay = delay
        self._keep_alive = keep_alive
        self._skip_ns = None if skip_empty is None else round(skip_empty * NS)
        self._immediate = immediate
        self._on_tick = on_tick
        self._pacer = pacer or Pacer()
        self._paused = paused
        self._steps = 0
        self._stop = threading.Event()
        self._next_tick = 0.0
        self._next_call = 0.0
        self._on_message: Callable[[str, Time], object] | None = None
        self._anchor = 0.0  # when the bags' time was `_anchor_ns`
        self._anchor_ns = self.timeline.start_ns
        self.position_ns = self.timeline.start_ns
        self.published = 0
        self._pause_topics = frozenset(pause_topics)
        self.pause_on_topics = True
        self._clock = ClockOutput(node, clock_hz) if clock_hz else None
        self._outputs = self._advertise(queue_size, on_left_out)
        self._control: RateControl | None = None
        if rate_control is not None:
            self._control = RateControl(node, rate_control, rate_control_delay, lambda: self.position_ns)

    # -- what a program calls -------------------------------------------------------------------------------

    def __enter__(self) -> Player:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    @property
    def paused(self) -> bool:
        """True while nothing is published."""
        return self._paused

    @property
    def waits_for(self) -> str:
        """The rate control topic while playing waits for it, otherwise ""."""
        return self._control.topic if self._control is not None and self._control.behind else ""

    @property
    def position(self) -> float:
        """Seconds of the span that have been played."""
        return (self.position_ns - self.timeline.start_ns) / NS

    @property
    def publishers(self) -> list[Publisher]:
        """One for each connection that is played."""
        return list(dict.fromkeys(self._outputs.values()))

    def pause(self) -> None:
        """Stop the bags' time."""
        self._paused = True

    def resume(self) -> None:
        """Let the bags' time continue from where it stopped."""
        self._steps = 0
        self._paused = False

    def step(self) -> None:
        """While paused: publish the next message."""
        if self._paused:
            self._steps += 1

    def stop(self) -> None:
        """Make `play` return soon."""
        self._stop.set()

    def wait_for_subscribers(self, timeout: float | None = 10.0) -> None:
        """Wait until every topic has a subscriber, or until `stop`.

        Raises:
            RosTimeout: One has none.
        """
        timeout = as_float(timeout)
        end = None if timeout is None else self._pacer.now() + timeout
        self._stop.clear()
        while not self._stop.is_set() and (alone := [p.topic for p in self.publishers if not p.connections]):
            if end is not None and self._pacer.now() > end:
                raise RosTimeout(
                    f"no subscriber for {', '.join(sorted(set(alone)))} after {timeout:g} s",
                    what="subscribers",
                    seconds=timeout,
                )
            self._rest(SHORT)

    def play(self, on_message: Callable[[str, Time], object] | None = None) -> int:
        """Publish everything; returns at the end, or after `stop`.

        Args:
            on_message: Called after each message, with its recorded topic and time.

        Returns:
            How many messages were published.

        Raises:
            BagError: A bag cannot be read any further.
            LocalProtocolError: The node was closed.
        """
        self._stop.clear()
        before = self.published
        self._on_message = on_message
        entries = self._begun()
        self._rest(self._delay)
        self._play_once(entries)
        while self._loop and self.published > before and not self._stop.is_set():
            self._play_once(self._begun())
        self._flush(2.0)
        while self._keep_alive and not self._stop.is_set():
            self._rest(TICK)
        return self.published - before

    def close(self) -> None:
        """Unregister the topics, after a moment for slow subscribers. May be called again."""
        self._stop.set()
        for publisher in self.publishers:
            publisher.close()
        if self._clock is not None:
            self._clock.close()
        if self._control is not None:
            self._control.close()

    # -- before the first message ---------------------------------------------------------------------------

    def _advertise(
        self, queue_size: int, on_left_out: Callable[[str], object] | None
    ) -> dict[tuple[int, int], Publisher]:
        """One publisher for each recorded one, since each latches its own message (as on /tf_static)."""
        shared: dict[tuple[str, str, str], Publisher] = {}
        outputs: dict[tuple[int, int], Publisher] = {}
        left_out: set[tuple[str, str, str]] = set()
        for number, connection in self.timeline.connections:
            key = (connection.topic, connection.callerid, connection.md5sum)
            if key not in shared and key not in left_out:
                try:
                    shared[key] = self._publisher(connection, queue_size)
                except BagError as problem:
                    if on_left_out is None:
                        raise
                    left_out.add(key)
                    on_left_out(str(problem))
            if key in shared:
                outputs[number, connection.id] = shared[key]
        return outputs

    def _publisher(self, connection: Connection, queue_size: int) -> Publisher:
        topic = self._prefix + self._remap.get(connection.topic, connection.topic)
        try:
            return self._node.publisher(
                topic, publishable_class_of(connection), latch=connection.latching, queue_size=queue_size
            )
        except LocalProtocolError as problem:
            raise BagError(
                f"{connection.topic} was recorded with different definitions, and a node can publish one, "
                f"not also {connection.type} (md5sum {connection.md5sum}): play those into another name"
            ) from problem

    # -- playing --------------------------------------------------------------------------------------------

    def _begun(self) -> Iterator[TimelineEntry]:
        """The entries to play, with the first chunk and all imports loaded before time starts to run.

        Otherwise the first messages would be late by tenths of a second and would arrive all at once.
        """
        entries = iter(self.timeline)
        return chain(list(islice(entries, 1)), entries)

    def _play_once(self, entries: Iterator[TimelineEntry]) -> None:
        latched = self.timeline.latched_before()
        self._anchor, self._anchor_ns = self._pacer.now(), self.timeline.start_ns
        self.position_ns = self.timeline.start_ns
        if self._control is not None:
            self._control.restart()
        if self._clock is not None:
            self._clock.publish(self.position_ns)
        for entry in latched:
            self._publish(entry)
        for entry in entries:
            if self.pause_on_topics and entry.message.connection.topic in self._pause_topics:
                self._paused = True
            if not self._wait_for(entry.time_ns):
                return
            self._publish(entry)
        if self._clock is not None:
            self._clock.publish(self.position_ns)

    def _publish(self, entry: TimelineEntry) -> None:
        publisher = self._outputs.get((entry.bag, entry.message.connection.id))
        if publisher is None:
            return  # left out
        try:
            publisher.publish(entry.message.data)
        except LocalProtocolError:
            if self._stop.is_set():
                return  # closed by another thread at this moment
            raise
        self.published += 1
        if self._on_message is not None:
            self._on_message(entry.message.connection.topic, Time.from_wire(*divmod(entry.time_ns, NS)))

    def _wait_for(self, time_ns: int) -> bool:
        """Wait until the bags' time is `time_ns`; False after `stop`."""
        if self._skip_ns is not None and time_ns - self.position_ns > self._skip_ns:
            self._set_anchor(time_ns)
        while not self._stop.is_set():
            now = self._pacer.now()
            if now >= self._next_tick:
                self._tick(now)
            if self._paused:
                if self._steps:
                    self._steps -= 1
                    self._set_anchor(time_ns)
                    return True
                self._stand(now)
                continue
            if self._control is not None and self._control.behind:
                self._stand(now)
                continue
            if self._immediate:
                if self.published % IMMEDIATE_BATCH == 0:
                    self._flush(10.0)  # wait for subscribers that cannot keep up, so that nothing is dropped
                self.position_ns = max(self.position_ns, time_ns)  # /clock must not go back
                return True
            due = self._anchor + (time_ns - self._anchor_ns) / NS / self._rate
            if self._wait_or_tick(now, due, time_ns):
                self.position_ns = max(self.position_ns, time_ns)  # /clock must not go back
                return True
        return False

    def _wait_or_tick(self, now: float, due: float, time_ns: int) -> bool:
        """Wait until a message is due or something else happens; True if the message is due."""
        if due <= now:
            return True
        until = min(due, self._next_tick)
        if self._clock is not None:
            until = min(until, self._clock.due)
        self._pacer.wait_until(until)
        if until == due:
            return True
        passed = (self._pacer.now() - self._anchor) * self._rate
        # When woken late, stay behind the message: a program that waits for this time would miss the message.
        self.position_ns = max(self.position_ns, min(time_ns, self._anchor_ns + int(passed * NS)))
        return False

    def _stand(self, now: float) -> None:
        """While paused: keep the bags' time constant."""
        self._set_anchor(self.position_ns)
        self._pacer.wait_until(min(now + TICK, self._clock.due if self._clock is not None else now + TICK))

    def _set_anchor(self, time_ns: int) -> None:
        self._anchor, self._anchor_ns = self._pacer.now(), time_ns
        self.position_ns = max(self.position_ns, time_ns)

    def _tick(self, now: float) -> None:
        self._next_tick = now + TICK
        if self._clock is not None:
            if now >= self._clock.due:
                self._clock.publish(self.position_ns)
                self._clock.advance(now)
            self._next_tick = min(self._next_tick, self._clock.due)
        if self._on_tick is not None and now >= self._next_call:
            self._next_call = now + TICK
            self._on_tick(self)

    def _rest(self, seconds: float) -> None:
        """Wait, calling `on_tick` in between."""
        end = self._pacer.now() + seconds
        while not self._stop.is_set() and (now := self._pacer.now()) < end:
            if now >= self._next_tick:
                self._tick(now)
            self._pacer.wait_until(min(end, self._next_tick))

    def _flush(self, timeout: float) -> None:
        for publisher in self.publishers:
            if not publisher.closed:
                try:
                    publisher.flush(timeout)
                except (RosTimeout, ConnectionError):
                    pass  # that subscriber hangs or has gone: its queue drops and counts; serve the others
