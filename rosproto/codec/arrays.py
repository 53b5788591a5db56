"""Arrays of numbers: accepted values and their conversion to bytes.

The generated code handles the common cases (an ndarray of the right dtype, bytes for uint8[]). This module
handles lists, tuples, other dtypes, strided views, ranges and `array.array`. numpy is imported on first use.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from typing_extensions import Buffer

    from rosproto.codec.binding import Part


def number_part(value: Any, code: str, dtype: str) -> tuple[Part, int]:
    """Convert a field's value to a part for `bytes.join`; return it with the number of elements.

    Args:
        value: The assigned value.
        code: struct code of one element.
        dtype: numpy dtype of one element.

    Raises:
        TypeError, ValueError, OverflowError, struct.error: The value does not fit.
    """
    kind = type(value)
    if kind is list or kind is tuple:
        # np.array(list) takes eight times as long; struct.pack(form, *value) builds the arguments twice.
        return struct.Struct(f"<{len(value)}{_pack_code(code)}").pack(*value), len(value)
    if isinstance(value, (bytes, bytearray)) or (isinstance(value, memoryview) and value.itemsize == 1):
        if code != "B":
            raise TypeError("bytes are only allowed for uint8[] and char[]")
        if isinstance(value, memoryview):
            return value.tobytes(), value.nbytes
        return value, len(value)
    if isinstance(value, (str, dict, set, frozenset)) or value is None:
        raise TypeError(f"a sequence of numbers is expected, not {kind.__name__}")
    try:
        memoryview(value)
    except (TypeError, ValueError, BufferError):
        if not hasattr(value, "__array_interface__"):
            items = tuple(value)
            return struct.pack(f"<{len(items)}{_pack_code(code)}", *items), len(items)
    return _from_array(value, dtype)


def fixed_part(value: object, code: str, dtype: str, length: int) -> Part:
    """`number_part` for `T[N]`; refuses any other number of elements."""
    part, count = number_part(value, code, dtype)
    if count != length:
        raise ValueError(f"{length} elements expected, not {count}")
    return part


def fixed_bytes(value: object, code: str, dtype: str, length: int) -> bytes:
    """`fixed_part` as bytes, for struct's "s"."""
    return bytes(fixed_part(value, code, dtype, length))


def _pack_code(code: str) -> str:
    # "?" packs the truth of any object: "false" would become True.
    return "B" if code == "?" else code


def _from_array(value: object, dtype: str) -> tuple[Part, int]:
    import numpy as np

    source = np.asarray(value)
    if source.ndim == 0:
        raise TypeError("a sequence of numbers is expected, not one number")
    wanted = np.dtype(dtype)
    if source.dtype != wanted:
        source = _converted(source, wanted)
    source = np.ascontiguousarray(source)
    return source, int(source.size)


def _converted(source: NDArray[np.generic], wanted: np.dtype[Any]) -> NDArray[np.generic]:
    """Change the dtype if every value fits; overflow, and floats for integers, are errors."""
    import numpy as np

    if source.dtype.kind not in "biuf" or source.size == 0:
        if source.size == 0:
            return source.astype(wanted) if source.dtype.kind in "biuf" else np.empty(source.shape, wanted)
        raise TypeError(f"numbers are expected, not dtype {source.dtype}")
    if wanted.kind == "b":
        if source.dtype.kind == "f":
            raise TypeError(f"booleans are expected, not dtype {source.dtype}")
        truth: NDArray[np.bool_] = source != 0
        return truth
    if wanted.kind == "f":
        with np.errstate(over="ignore"):
            result = source.astype(wanted)
        if not np.array_equal(np.isinf(result), np.isinf(source)):
            raise OverflowError(f"a value is out of range for {wanted}")
        return result
    if source.dtype.kind == "f":
        raise TypeError(f"integers are expected, not dtype {source.dtype}; use .astype({wanted.name!r})")
    low, high = np.iinfo(wanted).min, np.iinfo(wanted).max
    if int(source.min()) < low or int(source.max()) > high:
        raise OverflowError(f"values must be in {low}..{high}")
    return source.astype(wanted)


def bool_view(buffer: bytes | memoryview, count: int, offset: int) -> NDArray[np.bool_]:
    """Decode bool[] to a read-only copy; any non-zero byte is true."""
    import numpy as np

    result: NDArray[np.bool_] = np.frombuffer(buffer, "u1", count, offset) != 0
    result.flags.writeable = False
    return result


def plain_bools(values: Sequence[int]) -> list[bool]:
    """Decode bool[] to a list, as genpy does."""
    return [value != 0 for value in values]


def read_only(buffer: Buffer) -> memoryview:
    """A flat, read-only view of any buffer."""
    view = memoryview(buffer).toreadonly()
    return view if view.format == "B" and view.ndim == 1 else view.cast("B")
