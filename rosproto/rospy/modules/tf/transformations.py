"""Homogeneous matrices, Euler angles and quaternions (x, y, z, w); angles in radians.

Euler axes are four letters: "s" for rotations about static axes or "r" about rotating ones, then three of
x, y, z; the default is "sxyz" (roll, pitch, yaw).

Source: the conventions of tf.transformations (wiki.ros.org/tf); mathematics of K. Shoemake, "Euler angle
conversion", Graphics Gems IV.
"""

import math

import numpy

from ._tolerance import EPS as _EPS  # its name in tf


def identity_matrix():
    """(4, 4) identity."""
    return numpy.identity(4)


def translation_matrix(direction):
    """(4, 4) matrix of a translation."""
    matrix = numpy.identity(4)
    matrix[:3, 3] = direction[:3]
    return matrix


def translation_from_matrix(matrix):
    """The (3,) translation of a matrix."""
    return numpy.array(matrix)[:3, 3].copy()


def concatenate_matrices(*matrices):
    """Product of (4, 4) matrices."""
    product = numpy.identity(4)
    for matrix in matrices:
        product = numpy.dot(product, matrix)
    return product


def inverse_matrix(matrix):
    """Inverse of a matrix."""
    return numpy.linalg.inv(matrix)


def is_same_transform(matrix0, matrix1):
    """True if both matrices describe the same transform."""
    one, other = (numpy.array(m, dtype=float) / m[3][3] for m in (matrix0, matrix1))
    return numpy.allclose(one, other)


def vector_norm(data, axis=None, out=None):
    """Length of a vector, or lengths along an axis."""
    data = numpy.array(data, dtype=numpy.float64)
    if out is None and data.ndim == 1:
        return math.sqrt(numpy.dot(data, data))
    length = numpy.sqrt(numpy.atleast_1d(numpy.sum(data * data, axis=axis)))
    if out is None:
        return length
    out[...] = length
    return None


def unit_vector(data, axis=None, out=None):
    """Normalise a vector, or vectors along an axis, to length 1."""
    given = numpy.array(data, dtype=numpy.float64)
    if out is None and given.ndim == 1:
        return given / math.sqrt(numpy.dot(given, given))
    length = numpy.sqrt(numpy.atleast_1d(numpy.sum(given * given, axis)))
    unit = given / (length if axis is None else numpy.expand_dims(length, axis))
    if out is None:
        return unit
    out[...] = unit
    return None


# -- Euler angles -------------------------------------------------------------------------------------------


def _axes(axes):
    """Indices of the three axes for rotations about static axes, reverse order of the angles, odd parity.

    Odd parity: the second axis does not follow the first in the order x, y, z, x.
    """
    try:
        frame, letters = axes[0], axes[1:]
        first, second, third = ("xyz".index(letter) for letter in letters)
    except (TypeError, ValueError, IndexError, AttributeError):
        raise KeyError(axes) from None
    if frame not in "sr" or first == second or second == third:
        raise KeyError(axes)
    if frame == "r":  # rotating axes equal static axes in reverse order
        first, third = third, first
    return first, second, third, frame == "r", (first + 1) % 3 != second


def _ordered(ai, aj, ak, reverse, odd):
    if reverse:
        ai, ak = ak, ai
    return (-ai, -aj, -ak) if odd else (ai, aj, ak)


def quaternion_from_euler(ai, aj, ak, axes="sxyz"):
    """(4,) quaternion x, y, z, w of three Euler angles."""
    i, j, last, reverse, odd = _axes(axes)
    k = 3 - i - j
    if reverse:
        ai, ak = ak, ai
    if odd:
        aj = -aj
    ci, cj, ck = math.cos(ai / 2.0), math.cos(aj / 2.0), math.cos(ak / 2.0)
    si, sj, sk = math.sin(ai / 2.0), math.sin(aj / 2.0), math.sin(ak / 2.0)
    cc, cs, sc, ss = ci * ck, ci * sk, si * ck, si * sk
    q = numpy.empty((4,), dtype=numpy.float64)
    if last == i:
        q[i], q[j], q[k], q[3] = cj * (cs + sc), sj * (cc + ss), sj * (cs - sc), cj * (cc - ss)
    else:
        q[i], q[j] = cj * sc - sj * cs, cj * ss + sj * cc
        q[k], q[3] = cj * cs - sj * sc, cj * cc + sj * ss
    if odd:
        q[j] *= -1
    return q


def euler_matrix(ai, aj, ak, axes="sxyz"):
    """(4, 4) rotation matrix of three Euler angles."""
    i, j, last, reverse, odd = _axes(axes)
    k = 3 - i - j
    ai, aj, ak = _ordered(ai, aj, ak, reverse, odd)
    (si, sj, sk), (ci, cj, ck) = map(math.sin, (ai, aj, ak)), map(math.cos, (ai, aj, ak))
    cc, cs, sc, ss = ci * ck, ci * sk, si * ck, si * sk
    m = numpy.identity(4)
    if last == i:
        m[i, i], m[i, j], m[i, k] = cj, sj * si, sj * ci
        m[j, i], m[j, j], m[j, k] = sj * sk, -cj * ss + cc, -cj * cs - sc
        m[k, i], m[k, j], m[k, k] = -sj * ck, cj * sc + cs, cj * cc - ss
    else:
        m[i, i], m[i, j], m[i, k] = cj * ck, sj * sc - cs, sj * cc + ss
        m[j, i], m[j, j], m[j, k] = cj * sk, sj * ss + cc, sj * cs - sc
        m[k, i], m[k, j], m[k, k] = -sj, cj * si, cj * ci
    return m


def euler_from_matrix(matrix, axes="sxyz"):
    """Three Euler angles of a rotation matrix."""
    i, j, last, reverse, odd = _axes(axes)
    k = 3 - i - j
    m = numpy.array(matrix, dtype=float)[:3, :3]
    if last == i:
        middle = math.sqrt(m[i, j] * m[i, j] + m[i, k] * m[i, k])
        if middle > _EPS:
            angles = (
                math.atan2(m[i, j], m[i, k]),
                math.atan2(middle, m[i, i]),
                math.atan2(m[j, i], -m[k, i]),
            )
        else:
            angles = (math.atan2(-m[j, k], m[j, j]), math.atan2(middle, m[i, i]), 0.0)
    else:
        middle = math.sqrt(m[i, i] * m[i, i] + m[j, i] * m[j, i])
        if middle > _EPS:
            angles = (
                math.atan2(m[k, j], m[k, k]),
                math.atan2(-m[k, i], middle),
                math.atan2(m[j, i], m[i, i]),
            )
        else:
            angles = (math.atan2(-m[j, k], m[j, j]), math.atan2(-m[k, i], middle), 0.0)
    if odd:  # odd parity reverses the rotation
        angles = tuple(-angle for angle in angles)
    return angles[::-1] if reverse else angles


def euler_from_quaternion(quaternion, axes="sxyz"):
    """Three Euler angles of a quaternion x, y, z, w."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


# -- quaternions --------------------------------------------------------------------------------------------


def _multiply(q1, q0):
    x0, y0, z0, w0 = q0
    x1, y1, z1, w1 = q1
    return (
        x1 * w0 + y1 * z0 - z1 * y0 + w1 * x0,
        -x1 * z0 + y1 * w0 + z1 * x0 + w1 * y0,
        x1 * y0 - y1 * x0 + z1 * w0 + w1 * z0,
        -x1 * x0 - y1 * y0 - z1 * z0 + w1 * w0,
    )


def quaternion_multiply(quaternion1, quaternion0):
    """Product of two quaternions: rotation 0, then rotation 1."""
    return numpy.array(_multiply(quaternion1, quaternion0), dtype=numpy.float64)


def quaternion_conjugate(quaternion):
    """Conjugate; for a unit quaternion the inverse."""
    x, y, z, w = quaternion
    return numpy.array((-x, -y, -z, w), dtype=numpy.float64)


def quaternion_inverse(quaternion):
    """Inverse of a quaternion."""
    return quaternion_conjugate(quaternion) / numpy.dot(quaternion, quaternion)


def quaternion_about_axis(angle, axis):
    """Quaternion of a rotation about an axis of any length."""
    q = numpy.zeros((4,), dtype=numpy.float64)
    q[:3] = axis[:3]
    length = vector_norm(q)
    if length > _EPS:
        q *= math.sin(angle / 2.0) / length
    q[3] = math.cos(angle / 2.0)
    return q


def quaternion_matrix(quaternion):
    """(4, 4) rotation matrix of a quaternion of any length."""
    q = numpy.array(quaternion[:4], dtype=numpy.float64)
    square = numpy.dot(q, q)
    if square < _EPS:
        return numpy.identity(4)
    q *= math.sqrt(2.0 / square)
    p = numpy.outer(q, q)
    matrix = numpy.identity(4)
    matrix[:3, :3] = (
        (1.0 - p[1, 1] - p[2, 2], p[0, 1] - p[2, 3], p[0, 2] + p[1, 3]),
        (p[0, 1] + p[2, 3], 1.0 - p[0, 0] - p[2, 2], p[1, 2] - p[0, 3]),
        (p[0, 2] - p[1, 3], p[1, 2] + p[0, 3], 1.0 - p[0, 0] - p[1, 1]),
    )
    return matrix


def quaternion_from_matrix(matrix):
    """Quaternion x, y, z, w of a rotation matrix."""
    m = numpy.array(matrix, dtype=numpy.float64)[:4, :4]
    q = numpy.empty(4)
    trace = numpy.trace(m)
    if trace > m[3, 3]:
        q[:] = (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], trace)
    else:
        i = int(numpy.argmax((m[0, 0], m[1, 1], m[2, 2])))
        j, k = (i + 1) % 3, (i + 2) % 3
        trace = m[i, i] - (m[j, j] + m[k, k]) + m[3, 3]
        q[i], q[j], q[k], q[3] = trace, m[i, j] + m[j, i], m[k, i] + m[i, k], m[k, j] - m[j, k]
    return q * (0.5 / math.sqrt(trace * m[3, 3]))


def quaternion_slerp(quat0, quat1, fraction, spin=0, shortestpath=True):
    """Spherical linear interpolation between two quaternions."""
    q0, q1 = unit_vector(quat0[:4]), unit_vector(quat1[:4])
    if fraction in (0.0, 1.0):
        return q1 if fraction else q0
    d = float(numpy.dot(q0, q1))
    if abs(abs(d) - 1.0) < _EPS:
        return q0
    if shortestpath and d < 0.0:
        d, q1 = -d, -q1
    angle = math.acos(d) + spin * math.pi
    if abs(angle) < _EPS:
        return q0
    scale = 1.0 / math.sin(angle)
    return q0 * (math.sin((1.0 - fraction) * angle) * scale) + q1 * (math.sin(fraction * angle) * scale)


def random_quaternion(rand=None):
    """Uniformly distributed random unit quaternion."""
    u = numpy.random.rand(3) if rand is None else rand
    a, b = math.sqrt(1.0 - u[0]), math.sqrt(u[0])
    s, t = 2.0 * math.pi * u[1], 2.0 * math.pi * u[2]
    return numpy.array((math.sin(s) * a, math.cos(s) * a, math.sin(t) * b, math.cos(t) * b))


def random_rotation_matrix(rand=None):
    """Uniformly distributed random (4, 4) rotation matrix."""
    return quaternion_matrix(random_quaternion(rand))


def random_vector(size):
    """Random numbers between 0 and 1."""
    return numpy.random.random(size)


from ._arcball import (  # noqa: E402  (they need what is above)
    Arcball,
    arcball_constrain_to_axis,
    arcball_map_to_sphere,
    arcball_nearest_axis,
)
from ._matrices import (  # noqa: E402
    clip_matrix,
    compose_matrix,
    decompose_matrix,
    orthogonalization_matrix,
    projection_from_matrix,
    projection_matrix,
    reflection_from_matrix,
    reflection_matrix,
    rotation_from_matrix,
    rotation_matrix,
    scale_from_matrix,
    scale_matrix,
    shear_from_matrix,
    shear_matrix,
    superimposition_matrix,
)
