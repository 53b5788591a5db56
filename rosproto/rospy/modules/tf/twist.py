"""Mean velocity of a frame relative to another over an interval."""

import numpy
import rospy

from . import transformations


def between(tf, tracking, observation, reference, reference_point, time, interval):
    """Velocity (m/s) and angular rate (rad/s) of `tracking` relative to `observation`, in `reference`."""
    latest = tf.getLatestCommonTime(observation, tracking)
    at = time or latest
    end = min(at + rospy.Duration(0.5 * interval.to_sec()), latest)
    begin = max(rospy.Time(0.0001) + interval, end) - interval
    seconds = (end - begin).to_sec()
    was, was_turned = tf.lookupTransform(observation, tracking, begin)
    is_, is_turned = tf.lookupTransform(observation, tracking, end)
    turn = numpy.dot(
        numpy.linalg.inv(transformations.quaternion_matrix(was_turned)),
        transformations.quaternion_matrix(is_turned),
    )
    angle, axis, _ = transformations.rotation_from_matrix(turn)
    velocity = [(b - a) / seconds for a, b in zip(was, is_)]
    rate = [part * angle / seconds for part in axis]
    back, back_turned = tf.lookupTransform(reference, tracking, at)
    rotation = transformations.quaternion_matrix(back_turned)[:3, :3]
    rate = numpy.dot(rotation, rate)
    velocity = numpy.dot(rotation, velocity) + numpy.cross(back, rate)
    origin = numpy.array((back[0], back[1], back[2], 1))
    moved, turned = tf.lookupTransform(reference, reference_point, at)
    pose = numpy.dot(transformations.translation_matrix(moved), transformations.quaternion_matrix(turned))
    offset = numpy.dot(pose, origin) - origin
    velocity += numpy.dot(rate, offset[:3])  # adds a scalar to each component, as tf does
    return tuple(velocity), tuple(rate)
