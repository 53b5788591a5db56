"""Arrays of messages that are all built alike: columns of one table of bytes.

Messages of a topic mostly differ in numbers only: their texts and arrays have one length. They have one size
then, every field lies at one offset in all of them, and a column is a strided view of their bytes, copied
once. Whether that holds is looked at field by field; where it does not, `NotUniform` says so, and `Columns`
takes them in the general way.
"""

from __future__ import annotations

from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

from rosproto.bag.arrow.arrays import from_numpy, listed, numbers, texts
from rosproto.bag.arrow.library import pyarrow
from rosproto.bag.arrow.schema import is_binary, struct_type

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rosproto.bag.arrow.schema import Want
    from rosproto.codec.layout import FieldLayout, Layout

__all__ = ["NotUniform", "Uniform"]


class NotUniform(Exception):
    """They differ in more than numbers, or are not followed here."""


class _Grid(NamedTuple):
    """Where copies of a message lie: how many in each direction, and the bytes from one to the next."""

    shape: tuple[int, ...]
    strides: tuple[int, ...]


class Uniform:
    """Arrays of messages of one size that lie one behind the other.

    Args:
        blob: The messages.
        count: How many; at least one.
    """

    def __init__(self, blob: bytes, count: int) -> None:
        self._pa = pyarrow()
        self._blob = blob
        self._size = len(blob) // count
        self._grid = _Grid((count,), (self._size,))

    def take(self, layout: Layout, want: Want) -> dict[str, Any]:
        """The wanted fields' arrays, by path.

        Raises:
            NotUniform: See there. Also for whatever does not have the form of its definition.
        """
        if self._message(self._grid, layout, 0, take=False, single=True)[1] != self._size:
            raise NotUniform
        found: dict[str, Any] = {}
        self._wanted(layout, 0, want, "", found)
        return found

    def _wanted(self, layout: Layout, at: int, want: Want, prefix: str, found: dict[str, Any]) -> None:
        for field in layout.fields:
            inside = want.get(field.name)
            path = prefix + field.name
            if inside is not None:
                if inside is True or "" in inside:
                    found[path], _ = self._field(self._grid, field, at, take=True, single=True)
                if inside is not True and any(inside):
                    assert field.layout is not None
                    self._wanted(field.layout, at, inside, path + ".", found)
            _, at = self._field(self._grid, field, at, take=False, single=True)

    def _field(
        self, grid: _Grid, field: FieldLayout, at: int, *, take: bool, single: bool
    ) -> tuple[Any, int]:
        """A field's array, None unless it is to be taken, and the offset behind it."""
        if field.is_array:
            return self._array(grid, field, at, take)
        if field.layout is not None:
            return self._message(grid, field.layout, at, take=take, single=single)
        if field.kind == "string":
            size = self._length(grid, at)
            after = self._within(at + 4, size)
            return (self._texts(grid, at + 4, size, single) if take else None), after
        after = self._within(at, field.size)
        return (numbers(field, self._cut(grid, at, field.size)) if take else None), after

    def _message(self, grid: _Grid, layout: Layout, at: int, *, take: bool, single: bool) -> tuple[Any, int]:
        if not layout.fields:
            return (self._pa.nulls(prod(grid.shape)) if take else None), at
        if not take and layout.fixed_size is not None:
            return None, self._within(at, layout.fixed_size)
        arrays: list[Any] = []
        for field in layout.fields:
            array, at = self._field(grid, field, at, take=take, single=single)
            arrays.append(array)
        if not take:
            return None, at
        kind = struct_type(layout, single=single)
        return self._pa.StructArray.from_arrays(arrays, fields=list(kind)), at

    def _array(self, grid: _Grid, field: FieldLayout, at: int, take: bool) -> tuple[Any, int]:
        import numpy as np

        if field.length is None:
            count = self._length(grid, at)
            at += 4
        else:
            count = field.length
        size = field.size if field.layout is None else field.layout.fixed_size
        if field.kind == "string" or size is None or (field.layout is not None and field.layout.is_light):
            raise NotUniform
        after = self._within(at, count * size)
        if not take:
            return None, after
        if field.layout is None:
            plain = self._cut(grid, at, count * size)
            values = plain if is_binary(field) else numbers(field, plain)
        else:
            inner = _Grid((*grid.shape, count), (*grid.strides, size))
            values = self._message(inner, field.layout, at, take=True, single=False)[0]
        return listed(field, values, np.full(prod(grid.shape), count, np.int64)), after

    # -- bytes -------------------------------------------------------------------------------------------

    def _within(self, at: int, size: int) -> int:
        if at + size > self._size:
            raise NotUniform
        return at + size

    def _length(self, grid: _Grid, at: int) -> int:
        """A length that is the same in all of them."""
        self._within(at, 4)
        lengths = self._view(grid, at, "<u4")
        if not lengths.size:
            raise NotUniform
        first = int(lengths.flat[0])
        if (lengths != first).any():
            raise NotUniform
        return first

    def _texts(self, grid: _Grid, at: int, size: int, coded: bool) -> Any:
        import numpy as np

        pa = self._pa
        count = prod(grid.shape)
        plain = self._cut(grid, at, size)
        table = plain.reshape(count, size) if size else None
        if coded and (table is None or (table == table[0]).all()):
            first = b"" if table is None else table[0].tobytes()
            only = texts(first, np.array([size], np.int64), coded=False)
            return pa.DictionaryArray.from_arrays(from_numpy(np.zeros(count, np.int32), pa.int32()), only)
        return texts(plain.tobytes(), np.full(count, size, np.int64), coded=coded)

    def _cut(self, grid: _Grid, at: int, size: int) -> NDArray[Any]:
        """So many bytes of each, one behind the other."""
        import numpy as np

        if not size or not prod(grid.shape):
            return np.zeros(0, np.uint8)
        kind = f"<u{size}" if size in (2, 4, 8) else f"V{size}" if size > 1 else "u1"
        plain: NDArray[Any] = self._view(grid, at, kind).copy().reshape(-1).view(np.uint8)
        return plain

    def _view(self, grid: _Grid, at: int, kind: str) -> NDArray[Any]:
        import numpy as np

        view: NDArray[Any] = np.ndarray(grid.shape, kind, self._blob, at, grid.strides)
        return view
