"""Arrow arrays of plain bytes: numbers, times, texts, and the lists that values belong to.

No value becomes a Python object: the bytes are handed to Arrow as they are, or through one numpy operation.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

from rosproto.bag.arrow.library import pyarrow
from rosproto.bag.arrow.schema import arrow_type, is_binary, number_type
from rosproto.codec.layout import DTYPES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosproto.codec.layout import FieldLayout

__all__ = ["from_numpy", "listed", "numbers", "offsets_of", "texts"]

_NS = 1_000_000_000


def numbers(field: FieldLayout, plain: Any) -> Any:
    """A field's values, one after the other, from their bytes (anything that has a buffer)."""
    import numpy as np

    pa = pyarrow()
    if field.kind == "time":
        parts = np.frombuffer(plain, "<u4" if field.base == "time" else "<i4").reshape(-1, 2)
        whole = parts[:, 0].astype(np.int64) * _NS + parts[:, 1]
        return from_numpy(whole, pa.timestamp("ns", "UTC") if field.base == "time" else pa.duration("ns"))
    if field.code == "?":
        return from_numpy(np.frombuffer(plain, np.uint8) != 0, pa.bool_())
    return from_numpy(np.frombuffer(plain, DTYPES[field.base]), number_type(field))


def from_numpy(values: NDArray[Any], kind: Any) -> Any:
    """An Arrow array of this type over the same memory; truth values are packed.

    Not `pyarrow.array`, which imports pandas, where there is one, to ask whether it knows the values.
    """
    import numpy as np

    pa = pyarrow()
    data = np.packbits(values, bitorder="little") if values.dtype == bool else np.ascontiguousarray(values)
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(data)])


def texts(plain: bytes, sizes: NDArray[np.int64], *, coded: bool) -> Any:
    """Strings of these sizes, one after the other.

    Args:
        plain: Their bytes.
        sizes: Of each, (N,) int64.
        coded: Dictionary-encoded.
    """
    import numpy as np

    pa = pyarrow()
    offsets = offsets_of(sizes).astype(np.int32)
    array = pa.Array.from_buffers(pa.string(), len(sizes), [None, pa.py_buffer(offsets), pa.py_buffer(plain)])
    try:
        array.validate(full=True)
    except pa.ArrowInvalid:  # not UTF-8, and Arrow's strings are always UTF-8
        ends = offsets.tolist()
        array = pa.array([plain[a:b].decode("utf-8", "replace") for a, b in pairwise(ends)], pa.string())
    return array.dictionary_encode() if coded else array


def listed(field: FieldLayout, values: Any, counts: NDArray[np.int64]) -> Any:
    """The values, grouped into the lists they belong to; of a binary field, bytes.

    Args:
        field: An array field.
        values: Its elements, one after the other: an Arrow array, or what has a buffer for a binary field.
        counts: Elements of each list, (N,) int64.
    """
    import numpy as np

    pa = pyarrow()
    kind = arrow_type(field, single=False)
    if is_binary(field):
        data = pa.py_buffer(values)
        if field.length:
            return pa.Array.from_buffers(kind, len(counts), [None, data])
        offsets = pa.py_buffer(offsets_of(counts).astype(np.int32))
        return pa.Array.from_buffers(kind, len(counts), [None, offsets, data])
    if field.length:
        return pa.FixedSizeListArray.from_arrays(values, type=kind)
    starts = from_numpy(offsets_of(counts).astype(np.int32), pa.int32())
    return pa.ListArray.from_arrays(starts, values, type=kind)


def offsets_of(sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where each of them begins when they are joined, and the end; (N + 1,) int64."""
    import numpy as np

    found = np.zeros(len(sizes) + 1, np.int64)
    np.cumsum(sizes, out=found[1:])
    return found
