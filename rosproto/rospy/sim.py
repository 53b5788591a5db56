"""`rosproto run --sim`: a simulated chassis in this process.

The only module of rosproto that imports woosh_pure; loaded only for that option.
"""

from __future__ import annotations

import atexit
from collections.abc import Iterable


def start(marks: Iterable[str] = (), files: Iterable[str] = ()) -> str:
    """Start a simulated chassis that runs until the program ends; return the URI of its master.

    Args:
        marks: "NAME=X,Y,YAW" in m, m and degrees.
        files: Lists of marks in the format of `woosh marks`.

    Raises:
        ValueError: A mark is malformed or inside a wall.
        FileNotFoundError: A list does not exist.
    """
    from woosh_pure import SimulatedChassis
    from woosh_pure.sim.site import site_of

    simulated = SimulatedChassis(site=site_of(None, marks, files))
    simulated.__enter__()
    # Registered before the program's exit functions, so it runs after them.
    atexit.register(simulated.close)
    return simulated.master_uri
