"""Unit quaternions as (x, y, z, w) tuples: the few operations a transform tree needs, without numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = ["conjugate", "from_matrix", "multiply", "normalized", "rotate", "slerp", "to_matrix"]

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation b, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(q: Quaternion) -> Quaternion:
    """The rotation back."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """v + 2 u x (u x v + w v), with u the vector part."""
    x, y, z, w = q
    vx, vy, vz = v
    cx = y * vz - z * vy + w * vx
    cy = z * vx - x * vz + w * vy
    cz = x * vy - y * vx + w * vz
    return (vx + 2 * (y * cz - z * cy), vy + 2 * (z * cx - x * cz), vz + 2 * (x * cy - y * cx))


def normalized(q: Quaternion) -> Quaternion:
    """Same rotation, length 1.

    Raises:
        ValueError: Its length is zero or not finite.
    """
    length = math.sqrt(sum(part * part for part in q))
    if not (length > 0 and math.isfinite(length)):
        raise ValueError(f"{q} is no rotation")
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


def slerp(a: Quaternion, b: Quaternion, ratio: float) -> Quaternion:
    """From a (0) to b (1) on the shorter arc at steady speed (tf2::Quaternion::slerp)."""
    dot = sum(x * y for x, y in zip(a, b, strict=True))
    sign = -1.0 if dot < 0 else 1.0
    angle = math.acos(min(1.0, abs(dot)))
    if angle < 1e-9:
        return a
    scale = math.sin(angle)
    s, t = math.sin((1 - ratio) * angle) / scale, sign * math.sin(ratio * angle) / scale
    return (s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2], s * a[3] + t * b[3])


def to_matrix(q: Quaternion) -> list[list[float]]:
    """Rotation matrix, three rows."""
    x, y, z, w = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def from_matrix(m: Sequence[Sequence[float]]) -> Quaternion:
    """From an orthonormal matrix; Shepperd's method divides by the largest part only."""
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0:
        s = 2 * math.sqrt(1 + trace)
        q = ((m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s, (m[1][0] - m[0][1]) / s, s / 4)
        return normalized(q)
    i = max(range(3), key=lambda axis: m[axis][axis])
    j, k = (i + 1) % 3, (i + 2) % 3
    s = 2 * math.sqrt(max(0.0, 1 + m[i][i] - m[j][j] - m[k][k]))
    parts = [0.0, 0.0, 0.0]
    parts[i], parts[j], parts[k] = s / 4, (m[j][i] + m[i][j]) / s, (m[k][i] + m[i][k]) / s
    return normalized((parts[0], parts[1], parts[2], (m[k][j] - m[j][k]) / s))
