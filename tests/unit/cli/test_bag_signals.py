"""What ends a recording or a replay in order, and what does not."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator

import pytest

from rosproto.cli.signals import interrupt_on_signals

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="a process of Windows cannot send itself SIGHUP"
)


@pytest.fixture(params=["SIGHUP", "SIGINT", "SIGTERM"])
def number(request: pytest.FixtureRequest) -> Iterator[int]:
    number = getattr(signal, request.param)
    before = signal.getsignal(number)
    yield number
    signal.signal(number, before)


def test_signals_interrupt(number: int) -> None:
    """And what was there before is there again afterwards."""
    signal.signal(number, signal.SIG_DFL)
    with pytest.raises(KeyboardInterrupt), interrupt_on_signals():
        signal.raise_signal(number)
    assert signal.getsignal(number) is signal.SIG_DFL


def test_what_nohup_started_outlives_its_terminal(number: int) -> None:
    """Only the end of the terminal stays ignored; Ctrl-C and kill are meant."""
    signal.signal(number, signal.SIG_IGN)
    hung_up, interrupted = number == getattr(signal, "SIGHUP", None), False
    try:
        with interrupt_on_signals():
            assert (signal.getsignal(number) is signal.SIG_IGN) is hung_up
            signal.raise_signal(number)
    except KeyboardInterrupt:
        interrupted = True
    assert interrupted is not hung_up
    assert signal.getsignal(number) is signal.SIG_IGN
