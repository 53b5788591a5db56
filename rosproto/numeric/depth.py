"""Depth images as pictures: to be looked at, or to be measured in (REP 118). Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["depth_millimetres", "visible_depth"]

_NEAR, _FAR = 255, 40
"""Greys; 0 is left to what was not measured."""


def depth_millimetres(metres: NDArray[np.floating]) -> NDArray[np.uint16]:
    """(height, width) uint16 in mm, 0 where nothing was measured; what is too far for it is 65535."""
    import numpy as np

    found = np.nan_to_num(metres.astype(np.float64) * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    return np.clip(np.rint(found), 0, 65535).astype(np.uint16)


def visible_depth(metres: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(height, width) uint8, scaled to what is in the image: nearest white, farthest dark, unmeasured black.

    Args:
        metres: (height, width) in m; NaN, infinity, zero and less are not measured.
    """
    import numpy as np

    depth = metres.astype(np.float64)
    seen = np.isfinite(depth) & (depth > 0.0)
    grey = np.zeros(depth.shape, np.uint8)
    if not seen.any():
        return grey
    near, far = float(depth[seen].min()), float(depth[seen].max())
    share = (depth[seen] - near) / (far - near) if far > near else np.zeros(int(seen.sum()))
    grey[seen] = np.rint(_NEAR - share * (_NEAR - _FAR)).astype(np.uint8)
    return grey
