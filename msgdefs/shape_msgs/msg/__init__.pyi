# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of shape_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.geometry_msgs.msg as _geometry_msgs
from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from msgdefs._fields import Integers as _Integers
from msgdefs._fields import UInt32Array as _UInt32Array
from rosproto.codec import Message as _Message

class Mesh(_Message):
    """shape_msgs/Mesh

    MeshTriangle[] triangles
    geometry_msgs/Point[] vertices
    """

    triangles: list[MeshTriangle]
    vertices: list[_geometry_msgs.Point]
    def __init__(
        self,
        triangles: _Sequence[MeshTriangle] = ...,
        vertices: _Sequence[_geometry_msgs.Point] = ...,
    ) -> None: ...

class MeshTriangle(_Message):
    """shape_msgs/MeshTriangle

    uint32[3] vertex_indices
    """

    vertex_indices: _UInt32Array
    def __init__(
        self,
        vertex_indices: _Integers = ...,
    ) -> None: ...

class Plane(_Message):
    """shape_msgs/Plane

    float64[4] coef
    """

    coef: _Float64Array
    def __init__(
        self,
        coef: _Floats = ...,
    ) -> None: ...

class SolidPrimitive(_Message):
    """shape_msgs/SolidPrimitive

    uint8 BOX=1
    uint8 SPHERE=2
    uint8 CYLINDER=3
    uint8 CONE=4
    uint8 BOX_X=0
    uint8 BOX_Y=1
    uint8 BOX_Z=2
    uint8 SPHERE_RADIUS=0
    uint8 CYLINDER_HEIGHT=0
    uint8 CYLINDER_RADIUS=1
    uint8 CONE_HEIGHT=0
    uint8 CONE_RADIUS=1

    uint8 type
    float64[] dimensions
    """

    BOX: _ClassVar[int] = 1
    SPHERE: _ClassVar[int] = 2
    CYLINDER: _ClassVar[int] = 3
    CONE: _ClassVar[int] = 4
    BOX_X: _ClassVar[int] = 0
    BOX_Y: _ClassVar[int] = 1
    BOX_Z: _ClassVar[int] = 2
    SPHERE_RADIUS: _ClassVar[int] = 0
    CYLINDER_HEIGHT: _ClassVar[int] = 0
    CYLINDER_RADIUS: _ClassVar[int] = 1
    CONE_HEIGHT: _ClassVar[int] = 0
    CONE_RADIUS: _ClassVar[int] = 1
    type: int
    dimensions: _Float64Array
    def __init__(
        self,
        type: int = ...,
        dimensions: _Floats = ...,
    ) -> None: ...
