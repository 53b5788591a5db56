"""Threads for each kind of blocking work, so that a stop or a drive never waits for a free one."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

__all__ = ["Workers"]

R = TypeVar("R")


class Workers:
    """A few threads for one purpose. They are started with the first job."""

    def __init__(self, name: str, most: int) -> None:
        self._name, self._most = name, most
        self._threads: ThreadPoolExecutor | None = None
        self._jobs: set[asyncio.Future[Any]] = set()

    def run(self, job: Callable[..., R], *arguments: Any) -> asyncio.Future[R]:
        """Start a job, which runs whether or not it is awaited. Call this in the event loop."""
        if self._threads is None:
            self._threads = ThreadPoolExecutor(self._most, thread_name_prefix=f"woosh:web {self._name}")
        future = asyncio.get_running_loop().run_in_executor(self._threads, job, *arguments)
        self._jobs.add(future)
        future.add_done_callback(self._forget)
        return future

    def _forget(self, job: asyncio.Future[Any]) -> None:
        self._jobs.discard(job)
        if not job.cancelled():
            job.exception()  # marks it as seen: whoever awaits the job gets it, otherwise it is ignored

    def close(self) -> None:
        """Accept no more jobs. Those that run end in their own bounded time."""
        threads, self._threads = self._threads, None
        if threads is not None:
            threads.shutdown(wait=False, cancel_futures=False)
