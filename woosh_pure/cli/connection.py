"""The chassis a command works on; leaving it by an error, Ctrl-C or a signal stops the motion first."""

from __future__ import annotations

import signal
import time
from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

from .output import Output

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.goal import GoalHandle
    from woosh_pure.outcome import Outcome

__all__ = ["connect", "follow"]


@contextmanager
def connect(args: Namespace, out: Output, *, sim_speed: float = 1.0) -> Iterator[Chassis]:
    """The chassis that the common options name."""
    from woosh_pure.chassis import Chassis

    with ExitStack() as stack:
        address = args.master or args.chassis
        if args.sim:
            if address:
                raise ValueError("--sim and an address contradict each other; give one of them")
            from woosh_pure.sim import SimulatedChassis

            sim = stack.enter_context(SimulatedChassis(speed=sim_speed))
            address = sim.master_uri
            out.line(f"simulated chassis at {address}")
        chassis = stack.enter_context(Chassis(address, host=args.host))
        try:
            yield chassis
        except BaseException:
            _stop(chassis, out)
            raise


def _stop(chassis: Chassis, out: Output) -> None:
    # A second Ctrl-C must not interrupt the stopping; it is bounded to a few seconds.
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    except ValueError:
        before = None
    try:
        if chassis.moved:
            out.line("stopping ...")
            out.line(chassis.stop(timeout=4.0).sentence())
    finally:
        if before is not None:
            signal.signal(signal.SIGINT, before)


def follow(handle: GoalHandle[Any], out: Output, describe: str, timeout: float | None) -> Outcome:
    """Wait for a goal with a line now and then; raises what is not an arrival."""
    out.line(f"{describe} ...")
    last = time.monotonic()

    def report(_: object) -> None:
        nonlocal last
        if time.monotonic() - last > 1.0:
            last = time.monotonic()
            out.line(f"  {handle.progress_line()}")

    handle.on_progress(report)
    return handle.wait(timeout)
