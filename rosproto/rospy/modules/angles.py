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
    """The angle to turn, by the shorter way."""
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


def _room(from_angle, left_limit, right_limit):
    """(whether an angle is between the limits, how far to the left one may turn, and to the right)."""
    ways = [shortest_angular_distance(from_angle, limit) for limit in (left_limit, right_limit)]
    others = [two_pi_complement(way) for way in ways]
    if ways[0] == 0:
        return True, 0, max(ways[1], others[1])
    if ways[1] == 0:
        return True, min(ways[0], others[0]), 0
    left, around_left = sorted((ways[0], others[0]))
    around_right, right = sorted((ways[1], others[1]))
    if left <= around_right or right >= around_left:
        return left_limit == -pi and right_limit == pi, around_right, around_left
    return True, left, right


def shortest_angular_distance_with_limits(from_angle, to_angle, left_limit, right_limit):
    """(whether both angles are within the limits, the angle to turn); limits in -pi to pi.

    When the left limit is the greater one, the allowed range is the arc that contains pi.
    """
    inside, left, right = _room(from_angle, left_limit, right_limit)
    way = shortest_angular_distance(from_angle, to_angle)
    around = two_pi_complement(way)
    if inside:
        for turn in (way, around):
            if left <= turn <= right:
                return True, turn
        left, right = _room(to_angle, left_limit, right_limit)[1:]
        pick = max if abs(left) < abs(right) else min
    else:
        pick = min if abs(left) < abs(right) else max
    if abs(left) == abs(right):
        return False, way if abs(way) < abs(around) else around
    return False, pick(way, around)


def shortest_angular_distance_with_large_limits(from_angle, to_angle, left_limit, right_limit):
    """The same for limits beyond -pi and pi; the left one must be the smaller."""
    way = shortest_angular_distance(from_angle, to_angle)
    ways = sorted((way, two_pi_complement(way)), key=abs)
    if left_limit <= right_limit:
        for turn in ways:
            if left_limit <= from_angle + turn <= right_limit:
                return left_limit <= from_angle <= right_limit, turn
    return False, ways[0]
