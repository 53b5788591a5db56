"""Homogeneous matrices, Euler angles and quaternions (x, y, z, w); angles in radians.

Euler axes are four letters: "s" for rotations about static axes or "r" about rotating ones, then three of
x, y, z; the default is "sxyz" (roll, pitch, yaw).

Source: the conventions of tf.transformations (wiki.ros.org/tf); mathematics of K. Shoemake, "Euler angle
conversion" and "Arcball", Graphics Gems IV.
"""

import math

import numpy

from ._matrices import *
from ._matrices import EPS, identity_matrix, translation_matrix, unit_vector, vector_norm

_EPS = EPS  # its name in tf


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
    if reverse:
        ai, ak = ak, ai
    if odd:
        ai, aj, ak = -ai, -aj, -ak
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
        if middle > EPS:
            angles = (
                math.atan2(m[i, j], m[i, k]),
                math.atan2(middle, m[i, i]),
                math.atan2(m[j, i], -m[k, i]),
            )
        else:
            angles = (math.atan2(-m[j, k], m[j, j]), math.atan2(middle, m[i, i]), 0.0)
    else:
        middle = math.sqrt(m[i, i] * m[i, i] + m[j, i] * m[j, i])
        if middle > EPS:
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


def quaternion_multiply(quaternion1, quaternion0):
    """Product of two quaternions: rotation 0, then rotation 1."""
    x0, y0, z0, w0 = quaternion0
    x1, y1, z1, w1 = quaternion1
    product = (
        x1 * w0 + y1 * z0 - z1 * y0 + w1 * x0,
        -x1 * z0 + y1 * w0 + z1 * x0 + w1 * y0,
        x1 * y0 - y1 * x0 + z1 * w0 + w1 * z0,
        -x1 * x0 - y1 * y0 - z1 * z0 + w1 * w0,
    )
    return numpy.array(product, dtype=numpy.float64)


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
    if length > EPS:
        q *= math.sin(angle / 2.0) / length
    q[3] = math.cos(angle / 2.0)
    return q


def quaternion_matrix(quaternion):
    """(4, 4) rotation matrix of a quaternion of any length."""
    q = numpy.array(quaternion[:4], dtype=numpy.float64)
    square = numpy.dot(q, q)
    if square < EPS:
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
    if abs(abs(d) - 1.0) < EPS:
        return q0
    if shortestpath and d < 0.0:
        d, q1 = -d, -q1
    angle = math.acos(d) + spin * math.pi
    if abs(angle) < EPS:
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


# -- composition ---------------------------------------------------------------------------------------------


def compose_matrix(scale=None, shear=None, angles=None, translate=None, perspective=None):
    """Product of perspective, translation, Euler angles (sxyz), shear and scaling, from left to right."""
    whole = identity_matrix()
    if perspective is not None:
        whole[3, :] = perspective[:4]
    if translate is not None:
        whole = numpy.dot(whole, translation_matrix(translate))
    if angles is not None:
        whole = numpy.dot(whole, euler_matrix(angles[0], angles[1], angles[2], "sxyz"))
    if shear is not None:
        part = identity_matrix()
        part[1, 2], part[0, 2], part[0, 1] = shear[2], shear[1], shear[0]
        whole = numpy.dot(whole, part)
    if scale is not None:
        whole = numpy.dot(whole, numpy.diag((scale[0], scale[1], scale[2], 1.0)))
    return whole / whole[3, 3]


def decompose_matrix(matrix):
    """(scale, shear, angles, translation, perspective) of a matrix.

    Raises:
        ValueError: The matrix cannot be decomposed.
    """
    m = numpy.array(matrix, dtype=numpy.float64).T
    if abs(m[3, 3]) < EPS:
        raise ValueError("M[3, 3] is zero")
    m /= m[3, 3]
    straight = m.copy()
    straight[:, 3] = 0.0, 0.0, 0.0, 1.0
    if not numpy.linalg.det(straight):
        raise ValueError("matrix is singular")
    perspective = numpy.array((0.0, 0.0, 0.0, 1.0))
    if any(abs(m[:3, 3]) > EPS):
        perspective = numpy.dot(m[:, 3], numpy.linalg.inv(straight.T))
        m[:, 3] = 0.0, 0.0, 0.0, 1.0
    translation = m[3, :3].copy()
    rows, scale, shear = m[:3, :3].copy(), numpy.zeros(3), [0.0, 0.0, 0.0]
    scale[0] = vector_norm(rows[0])
    rows[0] /= scale[0]
    shear[0] = numpy.dot(rows[0], rows[1])
    rows[1] -= rows[0] * shear[0]
    scale[1] = vector_norm(rows[1])
    rows[1] /= scale[1]
    shear[0] /= scale[1]
    shear[1] = numpy.dot(rows[0], rows[2])
    rows[2] -= rows[0] * shear[1]
    shear[2] = numpy.dot(rows[1], rows[2])
    rows[2] -= rows[1] * shear[2]
    scale[2] = vector_norm(rows[2])
    rows[2] /= scale[2]
    shear[1:] = [part / scale[2] for part in shear[1:]]
    if numpy.dot(rows[0], numpy.cross(rows[1], rows[2])) < 0:
        scale, rows = -scale, -rows
    turn = numpy.identity(4)
    turn[:3, :3] = rows.T
    angles = list(euler_from_matrix(turn))
    return scale, shear, angles, translation, perspective


# -- arcball: rotation by the mouse --------------------------------------------------------------------------


def arcball_map_to_sphere(point, center, radius):
    """Map a point of the window to the unit sphere."""
    x, y = (point[0] - center[0]) / radius, (center[1] - point[1]) / radius
    beyond = x * x + y * y
    if beyond > 1.0:
        return numpy.array((x, y, 0.0)) / math.sqrt(beyond)
    return numpy.array((x, y, math.sqrt(1.0 - beyond)))


def arcball_constrain_to_axis(point, axis):
    """The point of the unit sphere nearest to `point` and perpendicular to `axis`."""
    point, axis = numpy.array(point, dtype=float), numpy.array(axis, dtype=float)
    flat = point - axis * numpy.dot(axis, point)
    length = vector_norm(flat)
    if length > EPS:
        return (-flat if flat[2] < 0.0 else flat) / length
    if axis[2] == 1.0:
        return numpy.array((1.0, 0.0, 0.0))
    return unit_vector([-axis[1], axis[0], 0.0])


def arcball_nearest_axis(point, axes):
    """The axis whose great circle is nearest to a point."""
    distances = [numpy.dot(arcball_constrain_to_axis(point, axis), point) for axis in axes]
    return axes[distances.index(max(distances))] if distances else None


class Arcball:
    """A virtual trackball in a window, rotated by dragging."""

    def __init__(self, initial=None):
        turn = numpy.array((0.0, 0.0, 0.0, 1.0) if initial is None else initial, dtype=float)
        if turn.shape == (4, 4):
            turn = quaternion_from_matrix(turn)
        elif turn.shape == (4,):
            turn = turn / vector_norm(turn)
        else:
            raise ValueError("initial not a quaternion or matrix.")
        self._before = self._at_down = self._turn = turn
        self._center, self._radius = [0.0, 0.0], 1.0
        self._grip = numpy.array((0.0, 0.0, 1.0))
        self._axes = self._axis = None
        self._constrained = False

    def place(self, center, radius):
        """Set position and radius of the ball in the window."""
        self._center[:] = center[:2]
        self._radius = float(radius)

    def setaxes(self, *axes):
        """Set the rotation axes of the constrained mode."""
        self._axes = [unit_vector(axis) for axis in axes]

    def setconstrain(self, constrain):
        """Enable or disable the constrained mode: rotation about the set axes only."""
        self._constrained = bool(constrain is True or constrain == 1)

    def getconstrain(self):
        """True in constrained mode."""
        return self._constrained

    def _on_ball(self, point):
        found = arcball_map_to_sphere(point, self._center, self._radius)
        return found if self._axis is None else arcball_constrain_to_axis(found, self._axis)

    def down(self, point):
        """Start a drag at a point of the window; selects the constraint axis."""
        self._axis = None
        grip = self._on_ball(point)
        if self._constrained and self._axes is not None:
            self._axis = arcball_nearest_axis(grip, self._axes)
            grip = self._on_ball(point)
        self._grip = grip
        self._at_down = self._before = self._turn

    def drag(self, point):
        """Rotate the ball for the mouse at a point of the window."""
        at = self._on_ball(point)
        self._before = self._turn
        across = numpy.cross(self._grip, at)
        if numpy.dot(across, across) < EPS:
            self._turn = self._at_down
        else:
            self._turn = quaternion_multiply((*across, numpy.dot(self._grip, at)), self._at_down)

    def next(self, acceleration=0.0):
        """Continue the rotation of the last drag."""
        turn = quaternion_slerp(self._before, self._turn, 2.0 + acceleration, False)
        self._before, self._turn = self._turn, turn

    def matrix(self):
        """The (4, 4) rotation matrix."""
        return quaternion_matrix(self._turn)
