"""Types of array fields, for the stubs of the doors beside this; there is no such module at run time.

Reading gives a numpy array, assigning takes any sequence of numbers; a descriptor says so to a type checker.
"""

from array import array
from collections.abc import Sequence
from typing import Any, Generic, SupportsFloat, SupportsIndex, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

Booleans: TypeAlias = Sequence[bool] | Sequence[np.bool_] | NDArray[np.bool_]
Floats: TypeAlias = (
    Sequence[SupportsFloat] | NDArray[np.floating[Any]] | NDArray[np.integer[Any]] | array[float] | array[int]
)
Integers: TypeAlias = Sequence[SupportsIndex] | NDArray[np.integer[Any]] | array[int]
Octets: TypeAlias = bytes | bytearray | memoryview | Integers

_S = TypeVar("_S", bound=np.generic)
_V = TypeVar("_V")

class _Array(Generic[_S, _V]):
    @overload
    def __get__(self, instance: None, owner: type[object], /) -> _Array[_S, _V]: ...
    @overload
    def __get__(self, instance: object, owner: type[object] | None = None, /) -> NDArray[_S]: ...
    def __set__(self, instance: object, value: _V, /) -> None: ...

BooleanArray: TypeAlias = _Array[np.bool_, Booleans]
Float32Array: TypeAlias = _Array[np.float32, Floats]
Float64Array: TypeAlias = _Array[np.float64, Floats]
Int8Array: TypeAlias = _Array[np.int8, Integers]
Int16Array: TypeAlias = _Array[np.int16, Integers]
Int32Array: TypeAlias = _Array[np.int32, Integers]
Int64Array: TypeAlias = _Array[np.int64, Integers]
UInt8Array: TypeAlias = _Array[np.uint8, Octets]
UInt16Array: TypeAlias = _Array[np.uint16, Integers]
UInt32Array: TypeAlias = _Array[np.uint32, Integers]
UInt64Array: TypeAlias = _Array[np.uint64, Integers]
