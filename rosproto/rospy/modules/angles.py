"""angles: arithmetic of angles in radians (wiki.ros.org/angles)."""

from math import fmod, pi


def normalize_angle_positive(angle):
    """The angle in 0 to 2 pi."""
    return angle % (2.0 * pi)


def normalize_angle(angle):
    """The angle in -pi to pi."""
    positive = normalize_angle_positive(angle)
    return positive - 2.0 * pi if positive > pi else positive


def shortest_angular_distance(from_angle, to_angle):
    """How far to turn, the short way."""
    return normalize_angle(to_angle - from_angle)


def two_pi_complement(angle):
    """The same turn the other way round."""
    if abs(angle) > 2 * pi:
        angle = fmod(angle, 2.0 * pi)
    if angle < 0:
        return 2 * pi + angle
    if angle > 0:
        return -2 * pi + angle
    return 2 * pi
