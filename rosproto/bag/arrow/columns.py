"""Serialized messages to Arrow arrays, field by field, for all messages of a batch at once.

One array holds the offset of the next field of each message. A field is read at all these offsets at once,
then each offset moves on by the size of that field. Fields that are not wanted are skipped. If the bytes do
not fit the definition, `DefinitionMismatch` is raised; the caller then decodes the messages one by one with
the codec, whose error names the field.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

from rosproto.bag.arrow.schema import WantedFields, arrow_type, is_binary, number_type, pyarrow, struct_type
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.codec.reference import LIGHT_PER_BYTE, LIGHT_SPARE

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pyarrow import Array, DataType

    Places = NDArray[np.int64]


_BY_SLICES = 64  # minimum bytes per message for copying by slices


class DefinitionMismatch(Exception):
    """A message does not fit its definition."""


class Columns:
    """Arrow arrays of the messages in a blob.

    Args:
        blob: Serialized messages, one after the other.
        start: Start of each, (N,) int64.
        end: End of each, (N,) int64.
    """

    def __init__(self, blob: bytes, start: Places, end: Places) -> None:
        self._pa = pyarrow()
        self._blob = blob
        self._start, self._end = start, end
        # Short messages may have many elements of (nearly) no bytes: limit their memory.
        self._light = LIGHT_SPARE + LIGHT_PER_BYTE * len(blob)

    def take(self, layout: Layout, want: WantedFields) -> dict[str, Array | None]:
        """The wanted fields' arrays, by path.

        Raises:
            DefinitionMismatch: Bytes and definition disagree.
        """
        found: dict[str, Array | None] = {}
        at = self._wanted(layout, self._start, self._end, want, "", found)
        # None: fields after the last wanted one were not looked at, so the end is unknown.
        if at is not None and (at != self._end).any():
            raise DefinitionMismatch
        return found

    def _wanted(
        self,
        layout: Layout,
        at: Places,
        end: Places,
        want: WantedFields,
        prefix: str,
        found: dict[str, Array | None],
    ) -> Places | None:
        """Fill `found`; returns the messages' ends, None if their last fields were not read."""
        left = len(want) - ("" in want)
        for field in layout.fields:
            if not left:
                return None
            inside = want.get(field.name)
            path = prefix + field.name
            if inside is None:
                _, at = self._field(field, at, end, take=False)
                continue
            left -= 1
            begun = at
            if inside is True or "" in inside:
                found[path], at = self._field(field, at, end, take=True)
            if inside is not True and any(inside_name for inside_name in inside):
                assert field.layout is not None
                after = self._wanted(field.layout, begun, end, inside, path + ".", found)
                if after is None and left:
                    _, after = self._field(field, begun, end, take=False)
                if after is None:
                    return None
                at = after
        return at

    # -- one field ---------------------------------------------------------------------------------------

    def _field(
        self, field: FieldLayout, at: Places, end: Places, *, take: bool, single: bool = True
    ) -> tuple[Array | None, Places]:
        """A field's array (None unless it is wanted), and the places after it."""
        if field.is_array:
            return self._array(field, at, end, take)
        if field.layout is not None:
            return self._message(field.layout, at, end, take, single)
        if field.kind == "string":
            text, after = self._bytes(at, end, take)
            return (texts(*text, coded=single) if take else None), after
        after = _moved(at, field.size, end)
        return (numbers(field, self._gather(at, field.size)) if take else None), after

    def _message(
        self, layout: Layout, at: Places, end: Places, take: bool, single: bool
    ) -> tuple[Array | None, Places]:
        if not layout.fields:
            return (self._pa.nulls(len(at)) if take else None), at
        if not take and layout.fixed_size is not None:
            return None, _moved(at, layout.fixed_size, end)
        arrays: list[Array | None] = []
        for field in layout.fields:
            array, at = self._field(field, at, end, take=take, single=single)
            arrays.append(array)
        if not take:
            return None, at
        kind = struct_type(layout, single=single)
        return self._pa.StructArray.from_arrays(arrays, fields=list(kind)), at

    def _array(self, field: FieldLayout, at: Places, end: Places, take: bool) -> tuple[Array | None, Places]:
        import numpy as np

        if field.length is None:
            counts = self._lengths(at, end)
            at = at + 4
        else:
            counts = np.full(len(at), field.length, np.int64)
        if (counts * field.size > end - at).any():
            raise DefinitionMismatch
        if field.layout is not None and field.layout.is_light:
            self._light -= int(counts.sum()) * field.layout.weight
            if self._light < 0:
                raise DefinitionMismatch
        if field.layout is None and field.kind != "string":
            values = None
            if take:
                plain = (
                    self._ranges(at, counts * field.size)
                    if field.length is None
                    else self._gather(at, field.length * field.size)
                )
                values = plain if is_binary(field) else numbers(field, plain)
            after = at + counts * field.size
        else:
            values, after = self._elements(field, at, end, counts, take)
        return (listed(field, values, counts) if take else None), after

    def _elements(
        self, field: FieldLayout, at: Places, end: Places, counts: Places, take: bool
    ) -> tuple[Array | None, Places]:
        """The elements of arrays of messages or strings, one after the other."""
        import numpy as np

        size = field.layout.fixed_size if field.layout is not None else None
        first = offsets_of(counts)
        if size is not None:
            after = at + counts * size
            if not take:
                return None, after
            each = np.arange(first[-1]) - np.repeat(first[:-1], counts)
            places = np.repeat(at, counts) + each * size
        else:
            places = np.empty(first[-1] if take else 0, np.int64)
            after = at.copy()
            # The next element of every message that still has one.
            for number in range(int(counts.max(initial=0))):
                which = np.flatnonzero(counts > number)
                if take:
                    places[first[which] + number] = after[which]
                after[which] = self._one(field, after[which], end[which], take=False)[1]
        if not take:
            return None, after
        return self._one(field, places, np.repeat(end, counts), take=True)[0], after

    def _one(self, field: FieldLayout, at: Places, end: Places, *, take: bool) -> tuple[Array | None, Places]:
        if field.layout is not None:
            return self._message(field.layout, at, end, take, False)
        text, after = self._bytes(at, end, take)
        return (texts(*text, coded=False) if take else None), after

    # -- bytes -------------------------------------------------------------------------------------------

    def _lengths(self, at: Places, end: Places) -> Places:
        import numpy as np

        _moved(at, 4, end)
        return _windows(self._blob, 4)[at].view("<u4").astype(np.int64) if len(at) else at

    def _bytes(self, at: Places, end: Places, take: bool) -> tuple[tuple[bytes, Places], Places]:
        """Strings: their bytes, their lengths, and the places after them."""
        sizes = self._lengths(at, end)
        at = at + 4
        if (sizes > end - at).any():
            raise DefinitionMismatch
        return (self._ranges(at, sizes) if take else b"", sizes), at + sizes

    def _gather(self, at: Places, size: int) -> NDArray[np.uint8] | bytes:
        """`size` bytes from each place, joined."""
        return _windows(self._blob, size)[at].view("u1") if len(at) and size else b""

    def _ranges(self, at: Places, sizes: Places) -> bytes:
        """`sizes` bytes from each place, joined."""
        import numpy as np

        total = int(sizes.sum())
        if not total:
            return b""
        if total > _BY_SLICES * len(at):
            blob = memoryview(self._blob)
            return b"".join([blob[a : a + size] for a, size in zip(at.tolist(), sizes.tolist(), strict=True)])
        first = offsets_of(sizes)
        index = np.arange(total) + np.repeat(at - first[:-1], sizes)
        return np.frombuffer(self._blob, np.uint8)[index].tobytes()


def _moved(at: Places, size: int, end: Places) -> Places:
    after = at + size
    if (after > end).any():
        raise DefinitionMismatch
    return after


def _windows(blob: bytes, size: int) -> NDArray[np.generic]:
    """A window of `size` bytes at every position of the blob."""
    import numpy as np

    kind = f"<u{size}" if size in (1, 2, 4, 8) else f"V{size}"  # numpy copies numbers faster
    windows: NDArray[np.generic] = np.ndarray((max(len(blob) - size + 1, 0),), kind, blob, 0, (1,))
    return windows


# -- arrays of Arrow ----------------------------------------------------------------------------------------
# Arrow arrays from bytes: numbers, times, strings and lists.
#
# Bytes are passed to Arrow unchanged or through one numpy operation, without Python objects.


_NS = 1_000_000_000


def numbers(field: FieldLayout, plain: NDArray[np.uint8] | bytes) -> Array:
    """A field's values from a buffer of their bytes."""
    import numpy as np

    pa = pyarrow()
    if field.kind == "time":
        parts = np.frombuffer(plain, "<u4" if field.base == "time" else "<i4").reshape(-1, 2)
        whole = parts[:, 0].astype(np.int64) * _NS + parts[:, 1]
        return from_numpy(whole, pa.timestamp("ns", "UTC") if field.base == "time" else pa.duration("ns"))
    if field.code == "?":
        return from_numpy(np.frombuffer(plain, np.uint8) != 0, pa.bool_())
    return from_numpy(np.frombuffer(plain, DTYPES[field.base]), number_type(field))


def from_numpy(values: NDArray[Any], kind: DataType) -> Array:
    """An Arrow array of this type over the same memory; booleans are packed.

    Not `pyarrow.array`, which imports pandas if it is installed.
    """
    import numpy as np

    pa = pyarrow()
    data = np.packbits(values, bitorder="little") if values.dtype == bool else np.ascontiguousarray(values)
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(data)])


def texts(plain: bytes, sizes: NDArray[np.int64], *, coded: bool) -> Array:
    """An array of strings from their joined bytes.

    Args:
        plain: The joined bytes.
        sizes: Bytes of each string, (N,) int64.
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


def listed(field: FieldLayout, values: Array | bytes | None, counts: NDArray[np.int64]) -> Array:
    """Values grouped into lists; bytes for a binary field.

    Args:
        field: An array field.
        values: Its elements: an Arrow array, or a buffer for a binary field.
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
    """The start of each part when joined, and the end; (N + 1,) int64."""
    import numpy as np

    found = np.zeros(len(sizes) + 1, np.int64)
    np.cumsum(sizes, out=found[1:])
    return found
