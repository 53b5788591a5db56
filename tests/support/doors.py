"""Holds a call in front of its method until the test lets it go on, so that the order of events is fixed."""

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
    """Let the calls of a method wait in front of its door; gives (one has come, they may go on)."""
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
    """Call it in a thread of its own; the thread, and where its error will be."""
    errors: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, errors
