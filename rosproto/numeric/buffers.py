"""A uint8[] field as a flat array."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def octets(data: Any) -> NDArray[np.uint8]:
    """A flat uint8 array: a view of arrays and bytes, a copy of lists."""
    if isinstance(data, (bytes, bytearray, memoryview)):
        return np.frombuffer(data, np.uint8) if len(data) else np.empty(0, np.uint8)
    array: NDArray[np.uint8] = np.asarray(data, np.uint8).reshape(-1)
    return array
