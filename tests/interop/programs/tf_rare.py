"""What few programs use of tf: Arcball, shears and projections taken apart, clip matrices, frames as a graph."""

import math

import numpy
import rospy
import tf
import tf2_ros
from geometry_msgs.msg import TransformStamped
from tf.transformations import *  # noqa: F403


def show(*values):
    """Print, the numbers rounded beyond what machines differ in."""
    for value in values:
        print(
            value
            if value is None or isinstance(value, (bool, str))
            else (numpy.round(value, 9) + 0.0).tolist()
        )


ball = Arcball()  # noqa: F405
show(ball.matrix())
ball.place((160, 120), 120)
for points in (((160, 120), (200, 100)), ((10, 10), (300, 30)), ((160, 120), (160, 120))):
    ball.down(points[0])
    ball.drag(points[1])
    ball.next()
    ball.next(0.5)
    show(ball.matrix())
ball.setaxes((1, 0, 0), (0, 1, 0), (0, 0, 2))
for constrained in (True, False, 1, 0, "yes"):
    ball.setconstrain(constrained)
    ball.down((100, 150))
    ball.drag((190, 90))
    show(ball.getconstrain(), ball.matrix())
show(Arcball(euler_matrix(0.1, 0.2, 0.3)).matrix(), Arcball((0, 0, 2, 2)).matrix())  # noqa: F405
for wrong in ((1, 2, 3), numpy.identity(3)):
    try:
        Arcball(wrong)  # noqa: F405
    except ValueError as error:
        print(error)
show(arcball_map_to_sphere((5, 5), (0, 0), 4), arcball_nearest_axis((1, 0, 0), [(0, 0, 1), (1, 0, 0)]))  # noqa: F405
show(arcball_constrain_to_axis((0, 0, 1), (0, 0, 1)), arcball_constrain_to_axis((1, 0, 0), (1, 0, 0)))  # noqa: F405
show(arcball_constrain_to_axis((1, 2, -3), (0, 1, 0)))  # noqa: F405

angle, direction, point = 0.7, (1.0, -2.0, 0.5), (0.3, 1.0, -2.0)
normal = numpy.cross(direction, (0.2, 0.9, 1.1))
shear = shear_matrix(angle, direction, point, normal)  # noqa: F405
found = shear_from_matrix(shear)  # noqa: F405
show(abs(found[0]), is_same_transform(shear, shear_matrix(*found)))  # noqa: F405
for arguments in ((point, normal), (point, normal, direction), (point, normal, None, (3.0, 2.0, 9.0))):
    if len(arguments) == 3:
        arguments = (point, normal, (0.4, 0.1, 1.0))
    flat = projection_matrix(*arguments)  # noqa: F405
    parts = projection_from_matrix(flat)  # noqa: F405
    show(*[part is None for part in parts[1:4]], parts[4], is_same_transform(flat, projection_matrix(*parts)))  # noqa: F405
flat = projection_matrix(point, normal, perspective=(3.0, 2.0, 9.0), pseudo=True)  # noqa: F405
parts = projection_from_matrix(flat, pseudo=True)  # noqa: F405
show(parts[4], is_same_transform(flat, projection_matrix(*parts)))  # noqa: F405
for frustum in ((-1, 2, -3, 4, 5, 6.5), (-1, 2, -3, 4, 5, 6.5, True)):
    show(clip_matrix(*frustum))  # noqa: F405
for frustum in ((1, 1, 0, 1, 1, 2), (0, 1, 0, 1, 0, 2, True)):
    try:
        clip_matrix(*frustum)  # noqa: F405
    except ValueError as error:
        print(error)
try:
    shear_from_matrix(numpy.diag((1.0, 2.0, 3.0, 1.0)))  # noqa: F405
except ValueError as error:
    print(error)

rospy.rostime.set_rostime_initialized(True)


def put(listener, parent, child, seconds, static=False, who="me"):
    """Tell of a frame."""
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = parent, child
    message.header.stamp, message.transform.rotation.w = rospy.Time(seconds), 1
    (listener.set_transform_static if static else listener.set_transform)(message, who)


buffer = tf2_ros.BufferCore()
print(buffer._allFramesAsDot(rospy.Time(1)))
put(buffer, "map", "odom", 10.5)
put(buffer, "map", "odom", 11)
put(buffer, "odom", "base", 12)
put(buffer, "base", "laser", 0, True, "you")
put(buffer, "world", "table", 1)
print(buffer._allFramesAsDot(rospy.Time(20)), buffer._allFramesAsDot())
transformer = tf.Transformer()
print(transformer.allFramesAsDot())
stamped = TransformStamped()
stamped.header.frame_id, stamped.child_frame_id, stamped.transform.rotation.w = "a", "b", math.cos(0)
transformer.setTransform(stamped)
print(transformer.allFramesAsDot(rospy.Time(3)))
try:
    transformer.allFramesAsDot(5.0)
except TypeError as error:
    print(error)
