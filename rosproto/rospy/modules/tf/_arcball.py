"""Mouse rotation by K. Shoemake's Arcball (Graphics Gems IV), with tf's names and results."""

import math

import numpy

from ._tolerance import EPS
from .transformations import (
    quaternion_from_matrix,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
    unit_vector,
    vector_norm,
)


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
