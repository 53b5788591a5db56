"""Threads of our own for what blocks: whatever keeps others busy, a stop and a drive have theirs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

__all__ = ["Workers"]

R = TypeVar("R")


class Workers:
    """A few threads for one purpose; none before the first job."""

    def __init__(self, name: str, most: int) -> None:
        self._name, self._most = name, most
        self._threads: ThreadPoolExecutor | None = None
        self._jobs: set[asyncio.Future[Any]] = set()

    def run(self, job: Callable[..., R], *arguments: Any) -> asyncio.Future[R]:
        """Begin a job; it is done whether somebody awaits it or not. Called in the event loop."""
        if self._threads is None:
            self._threads = ThreadPoolExecutor(self._most, thread_name_prefix=f"woosh:web {self._name}")
        future = asyncio.get_running_loop().run_in_executor(self._threads, job, *arguments)
        self._jobs.add(future)
        future.add_done_callback(self._forget)
        return future

    def _forget(self, job: asyncio.Future[Any]) -> None:
        self._jobs.discard(job)
        if not job.cancelled():
            job.exception()  # who awaits it sees it; nobody else has to

    def close(self) -> None:
        """No more jobs; those that run end by their own bounds."""
        threads, self._threads = self._threads, None
        if threads is not None:
            threads.shutdown(wait=False, cancel_futures=False)
