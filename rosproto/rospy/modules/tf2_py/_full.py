"""Two transforms one after the other by way of matrices, as tf2 combines lookups of two times.

Source: tf2/LinearMath/Matrix3x3.h and Transform.h (the order of each sum).
"""

import math


def matrix_of(q):
    """Three rows of a rotation."""
    x, y, z, w = q
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz = x * xs, x * ys, x * zs
    yy, yz, zz = y * ys, y * zs, z * zs
    return (
        (1.0 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1.0 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1.0 - (xx + yy)),
    )


def quaternion_of(m):
    """(x, y, z, w) of three rows."""
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0.0:
        s = math.sqrt(trace + 1.0)
        half = 0.5 / s
        return (m[2][1] - m[1][2]) * half, (m[0][2] - m[2][0]) * half, (m[1][0] - m[0][1]) * half, s * 0.5
    i = 1 if m[0][0] < m[1][1] else 0
    i = 2 if m[i][i] < m[2][2] else i
    j, k = (i + 1) % 3, (i + 2) % 3
    s = math.sqrt(m[i][i] - m[j][j] - m[k][k] + 1.0)
    q = [0.0, 0.0, 0.0, 0.0]
    q[i] = s * 0.5
    s = 0.5 / s
    q[3] = (m[k][j] - m[j][k]) * s
    q[j] = (m[j][i] + m[i][j]) * s
    q[k] = (m[k][i] + m[i][k]) * s
    return tuple(q)


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def combined(second, first):
    """(translation, rotation) of `first`, then `second`."""
    (translation, rotation), (there, turned) = second, first
    a, b = matrix_of(rotation), matrix_of(turned)
    product = [[_dot(row, column) for column in zip(*b)] for row in a]
    moved = tuple(_dot(row, there) + offset for row, offset in zip(a, translation))
    return moved, quaternion_of(product)
