# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of std_msgs as classes."""

from collections.abc import Sequence as _Sequence

from msgdefs._fields import Float32Array as _Float32Array
from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from msgdefs._fields import Int16Array as _Int16Array
from msgdefs._fields import Int32Array as _Int32Array
from msgdefs._fields import Int64Array as _Int64Array
from msgdefs._fields import Int8Array as _Int8Array
from msgdefs._fields import Integers as _Integers
from msgdefs._fields import Octets as _Octets
from msgdefs._fields import UInt16Array as _UInt16Array
from msgdefs._fields import UInt32Array as _UInt32Array
from msgdefs._fields import UInt64Array as _UInt64Array
from msgdefs._fields import UInt8Array as _UInt8Array
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration
from rosproto.time import Time as _Time

class Bool(_Message):
    """std_msgs/Bool

    bool data
    """

    data: bool
    def __init__(
        self,
        data: bool = ...,
    ) -> None: ...

class Byte(_Message):
    """std_msgs/Byte

    byte data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class ByteMultiArray(_Message):
    """std_msgs/ByteMultiArray

    # An array of byte with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    byte[] data              # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Int8Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class Char(_Message):
    """std_msgs/Char

    char data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class ColorRGBA(_Message):
    """std_msgs/ColorRGBA

    float32 r
    float32 g
    float32 b
    float32 a
    """

    r: float
    g: float
    b: float
    a: float
    def __init__(
        self,
        r: float = ...,
        g: float = ...,
        b: float = ...,
        a: float = ...,
    ) -> None: ...

class Duration(_Message):
    """std_msgs/Duration

    duration data
    """

    data: _Duration
    def __init__(
        self,
        data: _Duration = ...,
    ) -> None: ...

class Empty(_Message):
    """std_msgs/Empty
    """

    def __init__(self) -> None: ...

class Float32(_Message):
    """std_msgs/Float32

    float32 data
    """

    data: float
    def __init__(
        self,
        data: float = ...,
    ) -> None: ...

class Float32MultiArray(_Message):
    """std_msgs/Float32MultiArray

    # An array of float32 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    float32[] data           # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Float32Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Floats = ...,
    ) -> None: ...

class Float64(_Message):
    """std_msgs/Float64

    float64 data
    """

    data: float
    def __init__(
        self,
        data: float = ...,
    ) -> None: ...

class Float64MultiArray(_Message):
    """std_msgs/Float64MultiArray

    # An array of float64 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    float64[] data           # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Float64Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Floats = ...,
    ) -> None: ...

class Header(_Message):
    """std_msgs/Header

    # When and in which frame the data of a message is true.

    uint32 seq       # counts up by one per message of a publisher; filled in on publish
    time stamp       # time of the measurement, 0 when unknown; for a sensor the start of the sweep or exposure
    string frame_id  # coordinate frame of the data, by its tf name ("map", "base_link")
    """

    seq: int
    stamp: _Time
    frame_id: str
    def __init__(
        self,
        seq: int = ...,
        stamp: _Time = ...,
        frame_id: str = ...,
    ) -> None: ...

class Int16(_Message):
    """std_msgs/Int16

    int16 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class Int16MultiArray(_Message):
    """std_msgs/Int16MultiArray

    # An array of int16 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    int16[] data             # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Int16Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class Int32(_Message):
    """std_msgs/Int32

    int32 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class Int32MultiArray(_Message):
    """std_msgs/Int32MultiArray

    # An array of int32 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    int32[] data             # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Int32Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class Int64(_Message):
    """std_msgs/Int64

    int64 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class Int64MultiArray(_Message):
    """std_msgs/Int64MultiArray

    # An array of int64 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    int64[] data             # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Int64Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class Int8(_Message):
    """std_msgs/Int8

    int8 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class Int8MultiArray(_Message):
    """std_msgs/Int8MultiArray

    # An array of int8 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    int8[] data              # the elements, flat
    """

    layout: MultiArrayLayout
    data: _Int8Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class MultiArrayDimension(_Message):
    """std_msgs/MultiArrayDimension

    string label   # what this dimension is
    uint32 size    # number of elements along it
    uint32 stride  # elements from one index of it to the next, times its own size
    """

    label: str
    size: int
    stride: int
    def __init__(
        self,
        label: str = ...,
        size: int = ...,
        stride: int = ...,
    ) -> None: ...

class MultiArrayLayout(_Message):
    """std_msgs/MultiArrayLayout

    # How the flat data of a multi-dimensional array is laid out.
    # Element (i, j, k) is data[data_offset + i * dim[1].stride + j * dim[2].stride + k].

    MultiArrayDimension[] dim  # the dimensions, outermost first
    uint32 data_offset         # elements of padding before the data
    """

    dim: list[MultiArrayDimension]
    data_offset: int
    def __init__(
        self,
        dim: _Sequence[MultiArrayDimension] = ...,
        data_offset: int = ...,
    ) -> None: ...

class String(_Message):
    """std_msgs/String

    string data
    """

    data: str
    def __init__(
        self,
        data: str = ...,
    ) -> None: ...

class Time(_Message):
    """std_msgs/Time

    time data
    """

    data: _Time
    def __init__(
        self,
        data: _Time = ...,
    ) -> None: ...

class UInt16(_Message):
    """std_msgs/UInt16

    uint16 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class UInt16MultiArray(_Message):
    """std_msgs/UInt16MultiArray

    # An array of uint16 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    uint16[] data            # the elements, flat
    """

    layout: MultiArrayLayout
    data: _UInt16Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class UInt32(_Message):
    """std_msgs/UInt32

    uint32 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class UInt32MultiArray(_Message):
    """std_msgs/UInt32MultiArray

    # An array of uint32 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    uint32[] data            # the elements, flat
    """

    layout: MultiArrayLayout
    data: _UInt32Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class UInt64(_Message):
    """std_msgs/UInt64

    uint64 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class UInt64MultiArray(_Message):
    """std_msgs/UInt64MultiArray

    # An array of uint64 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    uint64[] data            # the elements, flat
    """

    layout: MultiArrayLayout
    data: _UInt64Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Integers = ...,
    ) -> None: ...

class UInt8(_Message):
    """std_msgs/UInt8

    uint8 data
    """

    data: int
    def __init__(
        self,
        data: int = ...,
    ) -> None: ...

class UInt8MultiArray(_Message):
    """std_msgs/UInt8MultiArray

    # An array of uint8 with any number of dimensions.

    MultiArrayLayout layout  # how data is to be read
    uint8[] data             # the elements, flat
    """

    layout: MultiArrayLayout
    data: _UInt8Array
    def __init__(
        self,
        layout: MultiArrayLayout = ...,
        data: _Octets = ...,
    ) -> None: ...
