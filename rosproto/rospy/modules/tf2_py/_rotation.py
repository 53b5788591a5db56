"""Quaternions (x, y, z, w) and vectors as tuples, each sum in tf2's order (tf2/LinearMath/Quaternion.h)."""

import math


def multiply(a, b):
    """First b, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def inverse(q):
    """The opposite rotation of a unit quaternion."""
    return -q[0], -q[1], -q[2], q[3]


def rotate(q, v):
    """A vector turned by a unit quaternion."""
    x, y, z, w = q
    vx, vy, vz = v
    turned = (
        w * vx + y * vz - z * vy,
        w * vy + z * vx - x * vz,
        w * vz + x * vy - y * vx,
        -x * vx - y * vy - z * vz,
    )
    return multiply(turned, inverse(q))[:3]


def add(a, b):
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def lerp(a, b, ratio):
    """Between two vectors."""
    rest = 1.0 - ratio
    return tuple(rest * one + ratio * other for one, other in zip(a, b))


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


def slerp(a, b, ratio):
    """Between two rotations at steady speed, the short way round."""
    dot = _dot(a, b)
    length = math.sqrt(_dot(a, a) * _dot(b, b))
    cosine = (-dot if dot < 0 else dot) / length
    theta = math.acos(min(1.0, max(-1.0, cosine))) * 2.0 / 2.0
    if theta == 0.0:
        return a
    d = 1.0 / math.sin(theta)
    s0, s1 = math.sin((1.0 - ratio) * theta), math.sin(ratio * theta)
    if dot < 0:
        return tuple((one * s0 + -other * s1) * d for one, other in zip(a, b))
    return tuple((one * s0 + other * s1) * d for one, other in zip(a, b))
