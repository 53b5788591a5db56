"""Where the examples drive: the chassis named on the command line, or a simulated one."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper

from woosh_pure import Chassis, SimulatedChassis


@contextmanager
def robot(speed: float = 4.0) -> Iterator[Chassis]:
    """A Chassis: `python examples/x.py 169.254.128.2` takes a real one."""
    if isinstance(sys.stdout, TextIOWrapper):  # a pipe or a file on Windows has no letters for Chinese texts
        sys.stdout.reconfigure(errors="backslashreplace")
    if len(sys.argv) > 1:
        with Chassis(sys.argv[1]) as chassis:
            yield chassis
    else:
        with SimulatedChassis(speed=speed) as sim, Chassis(sim.master_uri) as chassis:
            yield chassis
