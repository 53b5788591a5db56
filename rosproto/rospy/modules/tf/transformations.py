"""Homogeneous matrices, Euler angles and quaternions (x, y, z, w); angles in radians.

Euler axes are four letters: "s" for rotations about static axes or "r" about rotating ones, then three of
x, y, z; the default is "sxyz" (roll, pitch, yaw).

Source: the conventions of tf.transformations (wiki.ros.org/tf); mathematics of K. Shoemake, "Euler angle
conversion" and "Arcball", Graphics Gems IV.
"""

import math

import numpy

EPS = _EPS = numpy.finfo(float).eps * 4.0  # tf's name is the second one
"""Tolerance for rounding errors."""


# -- matrices ------------------------------------------------------------------------------------------------


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


def _array(values):
    return numpy.array(values[:3], dtype=numpy.float64)


def rotation_matrix(angle, direction, point=None):
    """Rotation by an angle in radians about an axis through a point or the origin."""
    sine, cosine = math.sin(angle), math.cos(angle)
    axis = unit_vector(direction[:3])
    turn = numpy.diag((cosine, cosine, cosine)) + numpy.outer(axis, axis) * (1.0 - cosine)
    x, y, z = axis * sine
    turn += ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))
    matrix = identity_matrix()
    matrix[:3, :3] = turn
    if point is not None:
        point = _array(point)
        matrix[:3, 3] = point - numpy.dot(turn, point)
    return matrix


def _fixed_direction(matrix, value=1.0):
    """Real eigenvector of an eigenvalue; the last one of several."""
    values, vectors = numpy.linalg.eig(matrix)
    found = numpy.where(abs(numpy.real(values) - value) < 1e-8)[0]
    if not len(found):
        raise ValueError("no unit eigenvector corresponding to eigenvalue %g" % value)
    return numpy.real(vectors[:, found[-1]]).squeeze()


def rotation_from_matrix(matrix):
    """(angle, axis, point) of a rotation."""
    m = numpy.array(matrix, dtype=numpy.float64)
    axis = _fixed_direction(m[:3, :3].T)
    point = _fixed_direction(m)
    point = point / point[3]
    cosine = (numpy.trace(m[:3, :3]) - 1.0) / 2.0
    if abs(axis[2]) > 1e-8:
        sine = (m[1, 0] + (cosine - 1.0) * axis[0] * axis[1]) / axis[2]
    elif abs(axis[1]) > 1e-8:
        sine = (m[0, 2] + (cosine - 1.0) * axis[0] * axis[2]) / axis[1]
    else:
        sine = (m[2, 1] + (cosine - 1.0) * axis[1] * axis[2]) / axis[0]
    return math.atan2(sine, cosine), axis, point


def scale_matrix(factor, origin=None, direction=None):
    """Scaling about the origin or a point, uniform or along one direction."""
    if direction is None:
        matrix = numpy.diag((factor, factor, factor, 1.0)).astype(numpy.float64)
        if origin is not None:
            matrix[:3, 3] = _array(origin) * (1.0 - factor)
        return matrix
    along = unit_vector(direction[:3])
    rest = 1.0 - factor
    matrix = identity_matrix()
    matrix[:3, :3] -= rest * numpy.outer(along, along)
    if origin is not None:
        matrix[:3, 3] = (rest * numpy.dot(origin[:3], along)) * along
    return matrix


def scale_from_matrix(matrix):
    """(factor, origin, direction) of a scaling; direction None for a uniform scaling."""
    m = numpy.array(matrix, dtype=numpy.float64)
    factor = float(numpy.trace(m[:3, :3]) - 2.0)
    try:
        direction = _fixed_direction(m[:3, :3], factor)
        direction = direction / vector_norm(direction)
    except ValueError:  # uniform
        factor, direction = (factor + 2.0) / 3.0, None
    origin = _fixed_direction(m)
    return factor, origin / origin[3], direction


def reflection_matrix(point, normal):
    """Reflection at the plane given by a point and a normal."""
    normal = unit_vector(normal[:3])
    matrix = identity_matrix()
    matrix[:3, :3] -= 2.0 * numpy.outer(normal, normal)
    matrix[:3, 3] = (2.0 * numpy.dot(point[:3], normal)) * normal
    return matrix


def reflection_from_matrix(matrix):
    """(point, normal) of a reflection."""
    m = numpy.array(matrix, dtype=numpy.float64)
    normal = _fixed_direction(m[:3, :3], -1.0)
    point = _fixed_direction(m)
    return point / point[3], normal


def projection_matrix(point, normal, direction=None, perspective=None, pseudo=False):
    """Projection onto a plane: orthogonal, along a direction, or from a perspective point."""
    point, normal = _array(point), unit_vector(normal[:3])
    matrix = identity_matrix()
    if perspective is not None:
        eye = _array(perspective)
        matrix[0, 0] = matrix[1, 1] = matrix[2, 2] = numpy.dot(eye - point, normal)
        matrix[:3, :3] -= numpy.outer(eye, normal)
        if pseudo:
            matrix[:3, :3] -= numpy.outer(normal, normal)
            matrix[:3, 3] = numpy.dot(point, normal) * (eye + normal)
        else:
            matrix[:3, 3] = numpy.dot(point, normal) * eye
        matrix[3, :3] = -normal
        matrix[3, 3] = numpy.dot(eye, normal)
        return matrix
    along = normal if direction is None else _array(direction)
    scale = 1.0 if direction is None else numpy.dot(along, normal)
    matrix[:3, :3] -= numpy.outer(along, normal) / scale
    matrix[:3, 3] = along * (numpy.dot(point, normal) / scale)
    return matrix


def shear_matrix(angle, direction, point, normal):
    """Shear along a direction in a plane; angle in radians."""
    normal, direction = unit_vector(normal[:3]), unit_vector(direction[:3])
    if abs(numpy.dot(normal, direction)) > 1e-6:
        raise ValueError("direction and normal vectors are not orthogonal")
    slope = math.tan(angle)
    matrix = identity_matrix()
    matrix[:3, :3] += slope * numpy.outer(direction, normal)
    matrix[:3, 3] = -slope * numpy.dot(point[:3], normal) * direction
    return matrix


def shear_from_matrix(matrix):
    """(angle, direction, point, normal) of a shear."""
    m = numpy.array(matrix, dtype=numpy.float64)
    values, vectors = numpy.linalg.eig(m[:3, :3])
    kept = numpy.real(vectors[:, abs(numpy.real(values) - 1.0) < 1e-4]).T
    if len(kept) < 2:
        raise ValueError("No two linear independent eigenvectors found %s" % (values,))
    normals = [numpy.cross(kept[i], kept[j]) for i in range(len(kept)) for j in range(i + 1, len(kept))]
    normal = max(normals, key=vector_norm)
    normal = normal / vector_norm(normal)
    direction = numpy.dot(m[:3, :3] - numpy.identity(3), normal)
    slope = vector_norm(direction)
    point = _fixed_direction(m)
    return math.atan(slope), direction / slope, point / point[3], normal


def projection_from_matrix(matrix, pseudo=False):
    """(point, normal, direction, perspective, pseudo) of a projection."""
    m = numpy.array(matrix, dtype=numpy.float64)
    values, vectors = numpy.linalg.eig(m)
    kept = numpy.where(abs(numpy.real(values) - 1.0) < 1e-8)[0]
    if not pseudo and len(kept):
        point = numpy.real(vectors[:, kept[-1]])
        direction, normal = (_lost_direction(part) for part in (m[:3, :3], m[:3, :3].T))
        if direction is None:
            raise ValueError("no eigenvector corresponding to eigenvalue 0")
        if normal is None:
            return point / point[3], direction, None, None, False
        return point / point[3], normal, direction, None, False
    kept = numpy.where(abs(numpy.real(values)) > 1e-8)[0]
    if not len(kept):
        raise ValueError("no eigenvector not corresponding to eigenvalue 0")
    point = numpy.real(vectors[:, kept[-1]])
    point, normal = point / point[3], -m[3, :3]
    eye = m[:3, 3] / numpy.dot(point[:3], normal)
    return point, normal, None, eye - normal if pseudo else eye, pseudo


def _lost_direction(matrix):
    """Direction that a (3, 3) matrix maps to zero; None if there is none."""
    values, vectors = numpy.linalg.eig(matrix)
    lost = numpy.where(abs(numpy.real(values)) < 1e-8)[0]
    return unit_vector(numpy.real(vectors[:, lost[0]])) if len(lost) else None


def clip_matrix(left, right, bottom, top, near, far, perspective=False):
    """Map a box, or a frustum with its apex at the origin, to normalised coordinates from -1 to 1."""
    if left >= right or bottom >= top or near >= far:
        raise ValueError("invalid frustrum")
    if perspective and near <= EPS:
        raise ValueError("invalid frustrum: near <= 0")
    low, high = numpy.array((left, bottom, near), dtype=float), numpy.array((right, top, far), dtype=float)
    size, middle = high - low, (high + low) / (high - low)
    if not perspective:
        matrix = numpy.diag((*(2.0 / size), 1.0))
        matrix[:3, 3] = -middle
        return matrix
    twice = 2.0 * near
    matrix = numpy.diag((-twice / size[0], -twice / size[1], -middle[2], 0.0))
    matrix[0, 2], matrix[1, 2] = middle[0], middle[1]
    matrix[2, 3], matrix[3, 2] = twice * far / size[2], -1.0
    return matrix


def orthogonalization_matrix(lengths, angles):
    """Map crystallographic cell coordinates (lengths, angles in degrees) to Cartesian ones."""
    a, b, c = lengths
    sines, cosines = numpy.sin(numpy.radians(angles)), numpy.cos(numpy.radians(angles))
    slant = (cosines[0] * cosines[1] - cosines[2]) / (sines[0] * sines[1])
    return numpy.array(
        (
            (a * sines[1] * math.sqrt(1.0 - slant * slant), 0.0, 0.0, 0.0),
            (-a * sines[1] * slant, b * sines[0], 0.0, 0.0),
            (a * cosines[1], b * cosines[0], c, 0.0),
            (0.0, 0.0, 0.0, 1.0),
        ),
        dtype=numpy.float64,
    )


def superimposition_matrix(v0, v1, scaling=False, usesvd=True):
    """Least-squares rigid transform (`scaling`: similarity) of points v0 to v1, both (3, N) or (4, N)."""
    v0 = numpy.array(v0, dtype=numpy.float64)[:3]
    v1 = numpy.array(v1, dtype=numpy.float64)[:3]
    if v0.shape != v1.shape or v0.shape[1] < 3:
        raise ValueError("vectors are of wrong shape or type")
    t0, t1 = numpy.mean(v0, axis=1), numpy.mean(v1, axis=1)
    v0, v1 = v0 - t0.reshape(3, 1), v1 - t1.reshape(3, 1)
    u, _, vh = numpy.linalg.svd(numpy.dot(v1, v0.T))
    turn = numpy.dot(u, vh)
    if numpy.linalg.det(turn) < 0.0:
        turn -= numpy.outer(u[:, 2], vh[2, :] * 2.0)
    matrix = numpy.identity(4)
    matrix[:3, :3] = turn
    if scaling:
        matrix[:3, :3] *= math.sqrt(numpy.sum(v1 * v1) / numpy.sum(v0 * v0))
    return numpy.dot(translation_matrix(t1), numpy.dot(matrix, translation_matrix(-t0)))


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
