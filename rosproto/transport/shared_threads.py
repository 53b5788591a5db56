"""Threads that all nodes and servers of this process share, for quick work and work that is due later.

A thread for each thing that waits costs memory, and a process may have few. What may wait long has a thread
of its own, or delays only itself: while one task waits, another thread takes the next.
"""

from __future__ import annotations

from rosproto.transport.forking import on_fork
from rosproto.worker_pool import WorkerPool

_MAX_THREADS = 10_000  # so many callbacks may wait at a time
_IDLE_SECONDS = 5.0
_pools: list[WorkerPool] = []


def shared_threads() -> WorkerPool:
    """The pool of this process; made on first use."""
    if not _pools:
        on_fork(_pools.clear)  # a fork has none of the threads
        _pools.append(
            WorkerPool("rosproto:shared", _MAX_THREADS, daemon=True, idle_seconds=_IDLE_SECONDS, gradual=True)
        )
    return _pools[0]
