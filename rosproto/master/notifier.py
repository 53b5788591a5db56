"""Send the master's notifications in the background: a queue per node, so that no node waits for another.

Calls to one node are made one after the other; calls to different nodes run in parallel, in a worker thread
for each node with something to send. Of several notifications with the same `key` only the newest is sent:
the current list of publishers matters, not its history. A replaced notification moves to the end of the
queue, so `/a` and `/a/b`, written alternately, arrive in an order that ends with the right tree.

Two groups of workers keep the number of threads bounded. A node belongs to the *prompt* group until a call to
it times out or its host cannot be reached. It then moves to the *patient* group, which has few threads, and
is tried again with growing pauses. So any number of dead nodes costs a few threads and delays only dead
nodes. A refused connection is final for the notifications queued before it: nothing listens there any more,
and a node that restarts registers again, which gives it the whole list. Idle threads end after a moment.
"""

from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from rosproto.coercion import as_float
from rosproto.logs import PeerLog, get_logger
from rosproto.master.notifications import Notification

_log = get_logger("rosproto.master")

# Seconds before each further attempt, a quarter of an hour in total: a laptop that was asleep gets the newest
# lists within a minute of waking. After that the node's queue is dropped.
PAUSES = (1.0, 2.0, 4.0, 8.0, 16.0, 30.0, *(60.0,) * 14)
IDLE_SECONDS = 1.0
MAX_SLOW_NODES = 1024  # remembered, so that their next call goes to the patient group at once


class DeliveryOutcome(Enum):
    """The outcome of one call."""

    DONE = "done"  # replied, whatever the reply: the node has received it
    GONE = "gone"  # the connection was refused
    SILENT = "silent"  # no answer in time, host unreachable: may be back later


class Sender(Protocol):
    """Makes calls to one node. Each worker opens one per node, so that its connection can be kept."""

    def send(self, note: Notification) -> DeliveryOutcome:
        """Make one call; return within the sender's own time-out, never raise."""
        ...

    def close(self) -> None:
        """Release the connection; a running `send` returns early where the system allows it."""
        ...


@dataclass(slots=True, eq=False)
class _Queue:
    """One node's notifications: key -> (number of the post, notification), the oldest first."""

    uri: str
    pending: dict[tuple[str, str], tuple[int, Notification]] = field(default_factory=dict)
    attempts: int = 0


class _WorkerGroup:
    """Due work and the threads for it. All state is guarded by the notifier's lock."""

    def __init__(self, name: str, workers: int, lock: threading.Lock) -> None:
        self.name = name
        self.max_threads = workers
        self.ready: list[tuple[float, int, _Queue]] = []  # heap by due time
        self.threads: set[threading.Thread] = set()
        self.idle = 0
        self.changed = threading.Condition(lock)


class Notifier:
    """Delivers notifications in the background.

    Args:
        connect: Opens a `Sender` for a URI.
        prompt_workers: Nodes served at the same time.
        patient_workers: Unresponsive nodes tried at the same time.
        pending_per_node: Most notifications kept for one node; beyond that the oldest is dropped.
    """

    def __init__(
        self,
        connect: Callable[[str], Sender],
        *,
        prompt_workers: int = 64,
        patient_workers: int = 8,
        pending_per_node: int = 10_000,
    ) -> None:
        self._connect = connect
        self._pending_per_node = pending_per_node
        self._lock = threading.Lock()
        self._prompt = _WorkerGroup("prompt", prompt_workers, self._lock)
        self._patient = _WorkerGroup("patient", patient_workers, self._lock)
        self._quiet = threading.Condition(self._lock)
        self._queues: dict[str, _Queue] = {}
        self._suspects: dict[str, None] = {}
        self._senders: set[Sender] = set()
        self._order = itertools.count()
        self._closed = False
        self._peer_log = PeerLog("rosproto.master")
        self._counts = dict.fromkeys(("sent", "replaced", "dropped", "failed"), 0)

    def post(self, note: Notification) -> None:
        """Queue a notification; never blocks. Ignored after `close`."""
        with self._lock:
            if self._closed:
                return
            queue = self._queues.get(note.uri)
            if queue is None:
                queue = self._queues[note.uri] = _Queue(note.uri)
                lane = self._patient if note.uri in self._suspects else self._prompt
                self._schedule(lane, queue, 0.0)
            if queue.pending.pop(note.key, None) is not None:
                self._counts["replaced"] += 1
            elif len(queue.pending) >= self._pending_per_node:
                del queue.pending[next(iter(queue.pending))]
                self._counts["dropped"] += 1
            queue.pending[note.key] = (next(self._order), note)

    def wait_until_quiet(self, timeout: float | None = 5.0) -> bool:
        """Wait until everything was delivered or given up; False after `timeout`."""
        with self._lock:
            return self._quiet.wait_for(lambda: not self._queues, as_float(timeout))

    def stats(self) -> dict[str, int]:
        """Counters sent, replaced, dropped, failed (calls given up), and the current nodes and threads."""
        with self._lock:
            threads = len(self._prompt.threads) + len(self._patient.threads)
            return {**self._counts, "nodes": len(self._queues), "threads": threads}

    def close(self, timeout: float = 2.0) -> None:
        """Drop queued notifications and end the threads, within `timeout` seconds; idempotent."""
        with self._lock:
            self._closed = True
            self._queues.clear()
            for lane in (self._prompt, self._patient):
                lane.ready.clear()
                lane.changed.notify_all()
            self._quiet.notify_all()
            senders = list(self._senders)
            threads = [*self._prompt.threads, *self._patient.threads]
        for sender in senders:
            sender.close()
        end = time.monotonic() + as_float(timeout)
        for thread in threads:
            if thread is not threading.current_thread():
                thread.join(max(0.0, end - time.monotonic()))

    # -- inside; all but `_work`, `_serve` and `_send` are called with the lock held ------------------------

    def _schedule(self, lane: _WorkerGroup, queue: _Queue, pause: float) -> None:
        assert self._lock.locked()
        heapq.heappush(lane.ready, (time.monotonic() + pause, next(self._order), queue))
        self._grow(lane)
        lane.changed.notify()

    def _grow(self, lane: _WorkerGroup) -> None:
        """Start a worker if more nodes are due than workers are idle."""
        if lane.idle >= len(lane.ready) or len(lane.threads) >= lane.max_threads:
            return
        name = f"rosproto:master-notify-{lane.name}"
        thread = threading.Thread(target=self._work, args=(lane,), name=name, daemon=True)
        lane.threads.add(thread)
        try:
            thread.start()
        except RuntimeError:  # the process has no thread left; a running worker takes over
            lane.threads.discard(thread)
            _log.warning("! cannot start another thread for notifications; %d are running", len(lane.threads))

    def _work(self, lane: _WorkerGroup) -> None:
        """One worker: serve due nodes until there were none for a while."""
        while True:
            with self._lock:
                queue = self._take(lane)
                if queue is None:
                    # With the lock still held since the decision, or `_grow` could count on this thread.
                    lane.threads.discard(threading.current_thread())
                    return
            self._serve(queue)

    def _take(self, lane: _WorkerGroup) -> _Queue | None:
        """The next due node; None if this worker should end."""
        give_up = time.monotonic() + IDLE_SECONDS
        lane.idle += 1
        try:
            while not self._closed:
                now = time.monotonic()
                if lane.ready and lane.ready[0][0] <= now:
                    queue = heapq.heappop(lane.ready)[2]
                    lane.idle -= 1
                    self._grow(lane)  # this worker may be busy for long; the next due node needs another
                    lane.idle += 1
                    return queue
                # One worker must stay for work that is due later; other idle workers may end.
                needed = bool(lane.ready) and lane.idle == 1
                if now >= give_up and not needed:
                    return None
                due = lane.ready[0][0] if lane.ready else give_up
                lane.changed.wait(max(0.0, (due if needed else min(due, give_up)) - now))
            return None
        finally:
            lane.idle -= 1

    def _serve(self, queue: _Queue) -> None:
        """Send the pending notifications of a node, one after the other."""
        sender = self._connect(queue.uri)
        with self._lock:
            self._senders.add(sender)
        try:
            while True:
                with self._lock:
                    if self._closed or not queue.pending:
                        self._queues.pop(queue.uri, None)
                        if not self._queues:
                            self._quiet.notify_all()
                        return
                    _, note = queue.pending.pop(next(iter(queue.pending)))
                    begun = next(self._order)
                outcome = self._send(sender, note)
                with self._lock:
                    if self._settle(queue, note, begun, outcome):
                        return
        finally:
            with self._lock:
                self._senders.discard(sender)
            sender.close()

    def _send(self, sender: Sender, note: Notification) -> DeliveryOutcome:
        try:
            return sender.send(note)
        except Exception:  # a worker must survive a sender's bug; the node is not to blame
            _log.exception("! sending %s to %s failed", note.key, note.uri)
            return DeliveryOutcome.GONE

    def _settle(self, queue: _Queue, note: Notification, begun: int, outcome: DeliveryOutcome) -> bool:
        """Record the outcome of one call; True if this worker has finished with the node for now."""
        assert self._lock.locked()
        if outcome is DeliveryOutcome.DONE:
            self._counts["sent"] += 1
            self._suspects.pop(queue.uri, None)
            queue.attempts = 0
            return False
        if self._closed:
            return True
        if outcome is DeliveryOutcome.SILENT and queue.attempts < len(PAUSES):
            # Repeat the same call first, unless a newer notification has replaced it meanwhile.
            if note.key not in queue.pending:
                queue.pending = {note.key: (begun, note), **queue.pending}
            self._suspect(queue.uri)
            pause = PAUSES[queue.attempts]
            queue.attempts += 1
            self._schedule(self._patient, queue, pause)
            return True
        # Notifications posted during the call are for a new node, perhaps at the same address.
        later = {key: item for key, item in queue.pending.items() if item[0] > begun}
        self._counts["failed"] += 1 + len(queue.pending) - len(later)
        log = self._peer_log.info if outcome is DeliveryOutcome.GONE else self._peer_log.warning
        text = "! %s is %s: gave up %s and later notifications"
        log(queue.uri, text, queue.uri, outcome.value, note.key)
        queue.pending, queue.attempts = later, 0
        return False

    def _suspect(self, uri: str) -> None:
        self._suspects.pop(uri, None)
        self._suspects[uri] = None
        if len(self._suspects) > MAX_SLOW_NODES:
            del self._suspects[next(iter(self._suspects))]
