"""`rosproto run --sim`: a simulated chassis in this process.

The one door upwards in the house: nothing else below woosh_pure may know it, and it is opened only by that
option.
"""

from __future__ import annotations

import atexit

__all__ = ["start"]


def start() -> str:
    """Start a simulated chassis that lives as long as the program; the URI of its master."""
    from woosh_pure import SimulatedChassis

    simulated = SimulatedChassis()
    simulated.__enter__()
    # Registered before the program's own: so it ends after them.
    atexit.register(simulated.close)
    return simulated.master_uri
