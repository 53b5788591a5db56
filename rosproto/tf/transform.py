"""A rigid transform between two frames, as a value.

Source: REP 103 (units, axes), geometry_msgs/TransformStamped.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from rosproto import quaternion
from rosproto.codec import DynamicMessage, message_class
from rosproto.quaternion import Quaternion, Vector
from rosproto.time import Time, TVal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from msgdefs.geometry_msgs.msg import TransformStamped

StampedMessage: TypeAlias = "TransformStamped | DynamicMessage"
"""A geometry_msgs/TransformStamped, of msgdefs or of any class with its fields."""

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)


def nanoseconds(time: TVal | float | None) -> int:
    """A Time, or seconds, in ns; None is 0."""
    if time is None:
        return 0
    return round(time * 1e9) if isinstance(time, (int, float)) else time.to_nsec()


@dataclass(frozen=True, slots=True)
class Transform:
    """`target_T_source`: converts coordinates in `source` to coordinates in `target`.

    It is also the pose of `source` in `target`. In a TransformStamped, `target` is header.frame_id (the
    parent) and `source` is child_frame_id.

    Attributes:
        target: Frame of the result.
        source: Frame of the data.
        translation: (x, y, z) of the source's origin in target, m.
        rotation: Unit quaternion (x, y, z, w).
        stamp_ns: Its time, ns, exactly as on the wire; 0 if it holds always.
    """

    target: str
    source: str
    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = IDENTITY
    stamp_ns: int = 0

    @classmethod
    def planar(
        cls, target: str, source: str, x: float, y: float, yaw: float, *, stamp: TVal | float = 0
    ) -> Transform:
        """A pose in the plane: x and y in m, yaw in rad counter-clockwise."""
        return cls(target, source, (x, y, 0.0), quaternion.from_yaw(yaw), nanoseconds(stamp))

    @classmethod
    def from_matrix(
        cls, target: str, source: str, matrix: ArrayLike, *, stamp: TVal | float = 0
    ) -> Transform:
        """From a homogeneous (4, 4) matrix with an orthonormal rotation part.

        Raises:
            ValueError: It is not a rigid transform.
        """
        import numpy as np

        values = np.asarray(matrix, dtype=np.float64)
        if values.shape != (4, 4) or not np.allclose(values[3], (0, 0, 0, 1)):
            raise ValueError(f"expected a (4, 4) matrix with last row 0 0 0 1, got shape {values.shape}")
        turn = values[:3, :3]
        if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) or np.linalg.det(turn) < 0:
            raise ValueError("the upper left (3, 3) part is not a rotation")
        x, y, z = values[:3, 3].tolist()
        rotation = quaternion.normalized(quaternion.from_matrix(turn.tolist()))
        return cls(target, source, (x, y, z), rotation, nanoseconds(stamp))

    @classmethod
    def from_message(cls, message: StampedMessage) -> Transform:
        """From a geometry_msgs/TransformStamped; leading slashes of names are removed (tf2 has none)."""
        t, r = message.transform.translation, message.transform.rotation
        return cls(
            message.header.frame_id.lstrip("/"),
            message.child_frame_id.lstrip("/"),
            (float(t.x), float(t.y), float(t.z)),
            (float(r.x), float(r.y), float(r.z), float(r.w)),
            message.header.stamp.to_nsec(),
        )

    def to_message(self) -> Any:
        """As a geometry_msgs/TransformStamped."""
        message = message_class("geometry_msgs/TransformStamped")()
        message.header.frame_id, message.child_frame_id = self.target, self.source
        message.header.stamp = self.stamp
        t, r = message.transform.translation, message.transform.rotation
        t.x, t.y, t.z = self.translation
        r.x, r.y, r.z, r.w = self.rotation
        return message

    @property
    def stamp(self) -> Time:
        """Its time."""
        return Time(*divmod(self.stamp_ns, 1_000_000_000))

    @property
    def inverse(self) -> Transform:
        """`source_T_target`."""
        back = quaternion.conjugate(self.rotation)
        x, y, z = quaternion.rotate(back, self.translation)
        return Transform(self.source, self.target, (-x, -y, -z), back, self.stamp_ns)

    def __matmul__(self, other: Transform) -> Transform:
        """`a_T_b @ b_T_c` is `a_T_c`, with the later of the two stamps.

        Raises:
            ValueError: The inner frames differ.
        """
        if self.source != other.target:
            raise ValueError(
                f"{self.target}_T_{self.source} @ {other.target}_T_{other.source}: the inner frames differ"
            )
        return Transform(
            self.target,
            other.source,
            self.point(other.translation),
            quaternion.multiply(self.rotation, other.rotation),
            max(self.stamp_ns, other.stamp_ns),
        )

    def point(self, point: Vector) -> Vector:
        """Convert one point from `source` to `target`."""
        x, y, z = quaternion.rotate(self.rotation, point)
        dx, dy, dz = self.translation
        return (x + dx, y + dy, z + dz)

    def points(self, points: ArrayLike) -> NDArray[np.float64]:
        """Convert points, (N, 3), from `source` to `target`; (N, 3) float64, a copy."""
        import numpy as np

        matrix = self.matrix
        moved: NDArray[np.float64] = np.asarray(points, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        return moved

    @property
    def matrix(self) -> NDArray[np.float64]:
        """Homogeneous (4, 4) float64: `matrix @ (x, y, z, 1)` converts source to target."""
        import numpy as np

        values = np.eye(4)
        values[:3, :3] = quaternion.to_matrix(self.rotation)
        values[:3, 3] = self.translation
        return values

    @property
    def yaw(self) -> float:
        """Rotation about z of the roll-pitch-yaw form, rad in [-pi, pi], counter-clockwise."""
        return quaternion.yaw_of(self.rotation)
