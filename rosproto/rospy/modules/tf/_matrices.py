"""(4, 4) matrices: translation, rotation, scaling, reflection, projection, shear; lengths of vectors.

Source: wiki.ros.org/tf, tf.transformations (names, arguments, results).
"""

import math

import numpy

EPS = numpy.finfo(float).eps * 4.0
"""Tolerance for rounding errors."""


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
