"""`rosproto run --sim`: a simulated chassis in this process.

The only module of rosproto that imports woosh_pure; it is loaded for that option alone.
"""

from __future__ import annotations

import atexit
from collections.abc import Iterable


def start(marks: Iterable[str] = (), files: Iterable[str] = ()) -> str:
    """Start a simulated chassis that runs as long as the program; returns the URI of its master.

    Args:
        marks: "NAME=X,Y,YAW" in m, m and degrees.
        files: Lists of marks as `woosh marks` keeps them.

    Raises:
        ValueError: A mark is malformed, or lies in a wall.
        FileNotFoundError: There is no such list.
    """
    from woosh_pure import SimulatedChassis
    from woosh_pure.sim.site import site_of

    simulated = SimulatedChassis(site=site_of(None, marks, files))
    simulated.__enter__()
    # Registered before the program's own exit functions, so it runs after them.
    atexit.register(simulated.close)
    return simulated.master_uri
