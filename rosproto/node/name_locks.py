"""One at a time for each name: while opening `/a` waits for the master, `/b` does not wait for `/a`."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rosproto.errors import RosTimeout
from rosproto.transport.deadline import Deadline


class NameLocks:
    """A lock for each name in use."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._locks: dict[str, tuple[threading.Lock, int]] = {}  # and how many hold it or wait for it

    @contextmanager
    def hold(self, name: str, deadline: Deadline | None = None) -> Iterator[None]:
        """Hold the lock of `name`.

        Raises:
            RosTimeout: Somebody else has held it until the deadline.
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
