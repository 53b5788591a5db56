"""Blocks calls of a method until the test releases them, so that the order of events is fixed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

__all__ = ["held", "in_thread"]


@contextmanager
def held(
    patch: pytest.MonkeyPatch, owner: object, name: str
) -> Iterator[tuple[threading.Event, threading.Event]]:
    """Block the calls of a method; yields two events (a call has begun, calls may continue)."""
    came, go_on = threading.Event(), threading.Event()
    original = getattr(owner, name)

    def wait_first(*arguments: Any, **options: Any) -> Any:
        came.set()
        assert go_on.wait(20.0)
        return original(*arguments, **options)

    patch.setattr(owner, name, wait_first)
    try:
        yield came, go_on
    finally:
        go_on.set()


def in_thread(call: Callable[[], object]) -> tuple[threading.Thread, list[BaseException]]:
    """Call it in a new thread; return the thread, and a list for its error."""
    errors: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, errors
