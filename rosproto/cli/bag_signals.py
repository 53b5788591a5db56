"""SIGTERM and a closed console end a recording or a replay as Ctrl-C does: in order."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["interrupt_on_signals"]


@contextmanager
def interrupt_on_signals() -> Iterator[None]:
    """Within the block these signals raise KeyboardInterrupt; outside the main thread nothing is changed.

    A SIGHUP that is ignored stays ignored: a recording under nohup outlives its terminal. An ignored SIGINT
    does not: a shell ignores it in whatever a script starts with `&`, and who sends it there means it.
    """
    before = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK"):
        number = getattr(signal, name, None)
        if number is not None and (name != "SIGHUP" or signal.getsignal(number) is not signal.SIG_IGN):
            try:
                before[number] = signal.signal(number, _interrupt)
            except ValueError:
                break  # not the main thread: whoever runs us owns the signals
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt
