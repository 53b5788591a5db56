"""Threads that all nodes of this process share, for quick work and work that is due later.

A thread for each thing that waits costs memory, and a process may have few. What may wait long has a thread
of its own, or delays only itself: while one task waits, another thread takes the next. They end with the last
node: a program that has closed its nodes has none of our threads left.
"""

from __future__ import annotations

import threading

from rosproto.transport.forking import on_fork
from rosproto.worker_pool import WorkerPool

_MAX_THREADS = 10_000  # so many callbacks may wait at a time
_IDLE_SECONDS = 5.0
_pools: list[WorkerPool] = []
_holders = 0
_lock = threading.Lock()


def shared_threads() -> WorkerPool:
    """The pool of this process; made on first use."""
    if not _pools:
        on_fork(_forget)
        _pools.append(
            WorkerPool("rosproto:shared", _MAX_THREADS, daemon=True, idle_seconds=_IDLE_SECONDS, gradual=True)
        )
    return _pools[0]


def hold_shared_threads() -> None:
    """Keep the threads until `release_shared_threads` is called."""
    global _holders
    with _lock:
        _holders += 1


def release_shared_threads(timeout: float) -> None:
    """End the threads if nobody else holds them, and wait for their end, unless called in one of them."""
    global _holders
    with _lock:
        _holders = max(0, _holders - 1)
        pool = _pools.pop() if _pools and not _holders else None
    if pool is not None:
        pool.close()
        pool.join(timeout)


def _forget() -> None:
    """A fork has none of the threads, and its nodes are closed."""
    global _lock, _holders
    _lock, _holders = threading.Lock(), 0
    _pools.clear()
