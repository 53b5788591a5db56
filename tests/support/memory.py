"""The peak memory of a piece of work."""

from __future__ import annotations

import os
import pickle
import select
import signal
import traceback
import tracemalloc
import warnings
from collections.abc import Callable

__all__ = ["peak_of"]

SECONDS = 60.0


def peak_of(work: Callable[[], object]) -> int:
    """The most bytes that `work` holds at a time, of those that Python and numpy allocate.

    It runs in a copy of this process that has no other thread. `tracemalloc.stop()` ends a process in which numpy
    allocates in another thread meanwhile: CPython before 3.12.9 and 3.13.2 (github.com/python/cpython/issues/128679).
    Where there is no fork it runs here.

    Raises:
        AssertionError: `work` raised; with its traceback.
    """
    if not hasattr(os, "fork"):
        return _traced(work)
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the copy takes no lock of another thread
        child = os.fork()
    if child == 0:
        try:
            try:
                answer: int | str = _traced(work)
            except BaseException:
                answer = traceback.format_exc()
            os.write(writing, pickle.dumps(answer))
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        try:
            ready = select.select([pipe], [], [], SECONDS)[0]
            told: int | str = pickle.loads(pipe.read()) if ready else f"no end after {SECONDS} s"
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    if isinstance(told, str):
        raise AssertionError(told)
    return told


def _traced(work: Callable[[], object]) -> int:
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
