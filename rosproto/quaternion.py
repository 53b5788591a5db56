"""Unit quaternions as (x, y, z, w) tuples, without numpy; each sum is taken in tf2's order.

The order decides the last digit, and programs print transforms: `rosproto.tf` and the rospy layer's tf2_py
compute with these functions, so that both print the same as a program over tf2's own library.

Source: tf2/LinearMath/Quaternion.h and Matrix3x3.h.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = [
    "Quaternion",
    "Vector",
    "conjugate",
    "from_matrix",
    "from_yaw",
    "multiply",
    "normalized",
    "rotate",
    "slerp",
    "to_matrix",
    "yaw_of",
]

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Matrix = Sequence[Sequence[float]]


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Rotation b followed by rotation a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse rotation."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """Rotate a vector: q v q*, with v as a quaternion whose w is 0."""
    x, y, z, w = q
    vx, vy, vz = v
    tx = w * vx + y * vz - z * vy
    ty = w * vy + z * vx - x * vz
    tz = w * vz + x * vy - y * vx
    tw = -x * vx - y * vy - z * vz
    return (
        tx * w - tw * x - ty * z + tz * y,
        ty * w - tw * y - tz * x + tx * z,
        tz * w - tw * z - tx * y + ty * x,
    )


def normalized(q: Quaternion) -> Quaternion:
    """The same rotation, with length 1.

    Raises:
        ValueError: Its length is zero or not finite.
    """
    length = math.sqrt(_dot(q, q))
    if not (length > 0 and math.isfinite(length)):
        raise ValueError(f"{q} is not a rotation")
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


def slerp(a: Quaternion, b: Quaternion, ratio: float) -> Quaternion:
    """Interpolate from a (0) to b (1) on the shorter arc at constant speed."""
    dot = _dot(a, b)
    cosine = abs(dot) / math.sqrt(_dot(a, a) * _dot(b, b))
    angle = math.acos(min(1.0, cosine))
    if angle == 0.0:
        return a
    d = 1.0 / math.sin(angle)
    s, t = math.sin((1.0 - ratio) * angle), math.sin(ratio * angle)
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    if dot < 0:
        bx, by, bz, bw = -bx, -by, -bz, -bw
    return ((ax * s + bx * t) * d, (ay * s + by * t) * d, (az * s + bz * t) * d, (aw * s + bw * t) * d)


def _dot(a: Quaternion, b: Quaternion) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


def to_matrix(q: Quaternion) -> list[list[float]]:
    """Rotation matrix, three rows. The quaternion may have any length; all zeros give the identity."""
    x, y, z, w = q
    square = x * x + y * y + z * z + w * w
    s = 2.0 / square if square else 0.0
    xs, ys, zs = x * s, y * s, z * s
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz = x * xs, x * ys, x * zs
    yy, yz, zz = y * ys, y * zs, z * zs
    return [
        [1.0 - (yy + zz), xy - wz, xz + wy],
        [xy + wz, 1.0 - (xx + zz), yz - wx],
        [xz - wy, yz + wx, 1.0 - (xx + yy)],
    ]


def from_matrix(m: Matrix) -> Quaternion:
    """The quaternion of an orthonormal matrix. Shepperd's method, which never divides by a small number."""
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0.0:
        s = math.sqrt(trace + 1.0)
        half = 0.5 / s
        return ((m[2][1] - m[1][2]) * half, (m[0][2] - m[2][0]) * half, (m[1][0] - m[0][1]) * half, s * 0.5)
    i = 1 if m[0][0] < m[1][1] else 0
    i = 2 if m[i][i] < m[2][2] else i
    j, k = (i + 1) % 3, (i + 2) % 3
    s = math.sqrt(m[i][i] - m[j][j] - m[k][k] + 1.0)
    half = 0.5 / s
    parts = [0.0, 0.0, 0.0]
    parts[i], parts[j], parts[k] = s * 0.5, (m[j][i] + m[i][j]) * half, (m[k][i] + m[i][k]) * half
    return (parts[0], parts[1], parts[2], (m[k][j] - m[j][k]) * half)


def yaw_of(q: Quaternion) -> float:
    """Rotation about z of the roll-pitch-yaw form, rad in [-pi, pi], counter-clockwise."""
    x, y, z, w = q
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def from_yaw(yaw: float) -> Quaternion:
    """A rotation about z by `yaw` rad, counter-clockwise."""
    return (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
