"""Homogeneous matrices, Euler angles and quaternions (x, y, z, w); angles in radians.

Axes of Euler angles are four letters: "s" for rotations about the fixed axes or "r" about the rotated ones,
then three of x, y, z: "sxyz" (roll, pitch, yaw) by default.

Source: the conventions of tf.transformations (wiki.ros.org/tf); the mathematics is K. Shoemake's, "Euler
angle conversion", Graphics Gems IV.
"""

import math

import numpy

_EPS = numpy.finfo(float).eps * 4.0


def identity_matrix():
    """(4, 4) identity."""
    return numpy.identity(4)


def translation_matrix(direction):
    """(4, 4) of a translation."""
    matrix = numpy.identity(4)
    matrix[:3, 3] = direction[:3]
    return matrix


def translation_from_matrix(matrix):
    """(3,) of a matrix."""
    return numpy.array(matrix)[:3, 3].copy()


def rotation_matrix(angle, direction, point=None):
    """(4, 4) of a rotation about an axis, through a point when given."""
    matrix = quaternion_matrix(quaternion_about_axis(angle, direction[:3]))
    if point is not None:
        point = numpy.array(point[:3], dtype=float)
        matrix[:3, 3] = point - matrix[:3, :3].dot(point)
    return matrix


def scale_matrix(factor, origin=None, direction=None):
    """(4, 4) of a scaling about the origin or a point."""
    matrix = numpy.diag((factor, factor, factor, 1.0))
    if origin is not None:
        matrix[:3, 3] = numpy.array(origin[:3]) * (1.0 - factor)
    return matrix


def concatenate_matrices(*matrices):
    """Their product."""
    product = numpy.identity(4)
    for matrix in matrices:
        product = numpy.dot(product, matrix)
    return product


def inverse_matrix(matrix):
    """The inverse."""
    return numpy.linalg.inv(matrix)


def is_same_transform(matrix0, matrix1):
    """True for two matrices that do the same."""
    one, other = (numpy.array(m, dtype=float) / m[3][3] for m in (matrix0, matrix1))
    return numpy.allclose(one, other)


def vector_norm(data, axis=None, out=None):
    """Length of vectors."""
    return numpy.sqrt(numpy.sum(numpy.array(data, dtype=float) ** 2, axis=axis))


def unit_vector(data, axis=None, out=None):
    """Vectors of length 1."""
    data = numpy.array(data, dtype=float)
    length = vector_norm(data, axis)
    return data / (length if axis is None else numpy.expand_dims(length, axis))


# -- Euler angles -------------------------------------------------------------------------------------------


def _axes(axes):
    """Indices of the three axes for fixed rotations, and whether the angles come in reverse."""
    try:
        frame, letters = axes[0], axes[1:]
        first, second, third = ("xyz".index(letter) for letter in letters)
    except (TypeError, ValueError, IndexError, AttributeError):
        raise KeyError(axes)
    if frame not in "sr" or first == second or second == third:
        raise KeyError(axes)
    # Rotations about rotated axes are those about fixed ones, in reverse.
    return ((third, second, first), True) if frame == "r" else ((first, second, third), False)


def quaternion_from_euler(ai, aj, ak, axes="sxyz"):
    """(4,) x, y, z, w of three angles."""
    order, reverse = _axes(axes)
    angles = (ak, aj, ai) if reverse else (ai, aj, ak)
    result = (0.0, 0.0, 0.0, 1.0)
    for axis, angle in zip(order, angles):
        turn = [0.0, 0.0, 0.0, math.cos(angle / 2.0)]
        turn[axis] = math.sin(angle / 2.0)
        result = _multiply(turn, result)
    return numpy.array(result, dtype=numpy.float64)


def euler_matrix(ai, aj, ak, axes="sxyz"):
    """(4, 4) of three angles."""
    order, reverse = _axes(axes)
    angles = (ak, aj, ai) if reverse else (ai, aj, ak)
    matrix = numpy.identity(4)
    for axis, angle in zip(order, angles):
        turn = numpy.identity(4)
        one, two = (axis + 1) % 3, (axis + 2) % 3
        turn[one, one] = turn[two, two] = math.cos(angle)
        turn[two, one] = math.sin(angle)
        turn[one, two] = -turn[two, one]
        matrix = turn.dot(matrix)
    return matrix


def euler_from_matrix(matrix, axes="sxyz"):
    """Three angles of a rotation matrix."""
    (i, j, last), reverse = _axes(axes)
    k = 3 - i - j
    m = numpy.array(matrix, dtype=float)[:3, :3]
    if last == i:
        middle = math.hypot(m[i, j], m[i, k])
        if middle > _EPS:
            angles = (
                math.atan2(m[i, j], m[i, k]),
                math.atan2(middle, m[i, i]),
                math.atan2(m[j, i], -m[k, i]),
            )
        else:
            angles = (math.atan2(-m[j, k], m[j, j]), math.atan2(middle, m[i, i]), 0.0)
    else:
        middle = math.hypot(m[i, i], m[j, i])
        if middle > _EPS:
            angles = (
                math.atan2(m[k, j], m[k, k]),
                math.atan2(-m[k, i], middle),
                math.atan2(m[j, i], m[i, i]),
            )
        else:
            angles = (math.atan2(-m[j, k], m[j, j]), math.atan2(-m[k, i], middle), 0.0)
    if (i + 1) % 3 != j:  # an odd order of the axes turns the other way round
        angles = tuple(-angle for angle in angles)
    return angles[::-1] if reverse else angles


def euler_from_quaternion(quaternion, axes="sxyz"):
    """Three angles of x, y, z, w."""
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
    """Their product: first 0, then 1."""
    return numpy.array(_multiply(quaternion1, quaternion0), dtype=numpy.float64)


def quaternion_conjugate(quaternion):
    """The opposite rotation of a unit quaternion."""
    x, y, z, w = quaternion
    return numpy.array((-x, -y, -z, w), dtype=numpy.float64)


def quaternion_inverse(quaternion):
    """The opposite rotation."""
    return quaternion_conjugate(quaternion) / numpy.dot(quaternion, quaternion)


def quaternion_about_axis(angle, axis):
    """A rotation about an axis of any length."""
    axis = unit_vector(axis[:3])
    return numpy.array((*(axis * math.sin(angle / 2.0)), math.cos(angle / 2.0)), dtype=numpy.float64)


def quaternion_matrix(quaternion):
    """(4, 4) of a rotation; the quaternion need not have length 1."""
    q = numpy.array(quaternion[:4], dtype=numpy.float64)
    square = numpy.dot(q, q)
    if square < _EPS:
        return numpy.identity(4)
    x, y, z, w = q / math.sqrt(square)
    matrix = numpy.identity(4)
    matrix[:3, :3] = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return matrix


def quaternion_from_matrix(matrix):
    """x, y, z, w of a rotation matrix."""
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
    """Between two rotations, at steady speed."""
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
    return (q0 * math.sin((1.0 - fraction) * angle) + q1 * math.sin(fraction * angle)) / math.sin(angle)


def random_quaternion(rand=None):
    """A rotation drawn evenly."""
    u = numpy.random.rand(3) if rand is None else rand
    a, b = math.sqrt(1.0 - u[0]), math.sqrt(u[0])
    s, t = 2.0 * math.pi * u[1], 2.0 * math.pi * u[2]
    return numpy.array((math.sin(s) * a, math.cos(s) * a, math.sin(t) * b, math.cos(t) * b))


def random_rotation_matrix(rand=None):
    """The same as a (4, 4) matrix."""
    return quaternion_matrix(random_quaternion(rand))


def compose_matrix(scale=None, shear=None, angles=None, translate=None, perspective=None):
    """(4, 4) of a translation, Euler angles (sxyz) and a scaling, in this order from the left."""
    matrix = numpy.identity(4)
    if translate is not None:
        matrix = matrix.dot(translation_matrix(translate))
    if angles is not None:
        matrix = matrix.dot(euler_matrix(*angles))
    if scale is not None:
        matrix = matrix.dot(numpy.diag((*scale, 1.0)))
    return matrix
