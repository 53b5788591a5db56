"""`rosproto run --sim`: a simulated chassis in this process.

The only import of woosh_pure below it: nothing else in rosproto may know the chassis, and this module is
loaded by that option alone.
"""

from __future__ import annotations

import atexit
from collections.abc import Iterable

__all__ = ["start"]


def start(marks: Iterable[str] = (), files: Iterable[str] = ()) -> str:
    """Start a simulated chassis that lives as long as the program; the URI of its master.

    Args:
        marks: "NAME=X,Y,YAW" in m, m and degrees.
        files: Lists of marks as `woosh marks` keeps them.

    Raises:
        ValueError: A mark is written wrong, or lies in a wall.
        FileNotFoundError: There is no such list.
    """
    from woosh_pure import SimulatedChassis
    from woosh_pure.sim.site_options import site_of

    simulated = SimulatedChassis(site=site_of(None, marks, files))
    simulated.__enter__()
    # Registered before the program's own: so it ends after them.
    atexit.register(simulated.close)
    return simulated.master_uri
