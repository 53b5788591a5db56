"""Message objects: texts, copies, pickles, equality, constants, nesting."""

import copy
import io
import pickle

import genpy
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Polygon, Pose, Twist, Vector3
from sensor_msgs.msg import Image, JointState, LaserScan
from std_msgs.msg import Header, MultiArrayDimension, String
from woosh_msgs.msg import StepControl, StepControlAction, StepControlGoal

twist = Twist(linear=Vector3(1, 0, 0))
print(twist)
print(repr(twist) == str(twist), twist == copy.deepcopy(twist), twist == Twist(), twist != Twist())
print(pickle.loads(pickle.dumps(twist)) == twist, pickle.loads(pickle.dumps(rospy.Time(3, 4))))
shared = copy.copy(twist)
print(shared.linear is twist.linear, copy.deepcopy(twist).linear is twist.linear)
print(StepControlGoal.EXCUTE, StepControlGoal.STRAIGHT, StepControlGoal.ROTATE, GoalStatus.SUCCEEDED)
goal = StepControlGoal(mode=StepControlGoal.EXCUTE)
goal.stepControl.append(StepControl())
print(goal)
print(type(StepControlAction().action_goal.goal).__name__, StepControlAction().action_goal.goal_id.id == "")
print(Image(data=b"\x00\x01\x02"))
print(JointState(name=["a", "b c", "d: e", "yes", "1", ""], position=[1.0, 2]))
print(
    String(
        "a text that is long enough to be folded, because it has more than eighty characters in one line, you see"
    )
)
print(String('two\nlines\ttab \u4e2d\u6587 "quoted" back\\slash'))
print(Polygon())
print(LaserScan(ranges=(1.0, float("inf"), float("nan"))))
print(MultiArrayDimension("x", 1, 2).__slots__, MultiArrayDimension._slot_types)
print(Twist._type, Twist._md5sum, Twist._has_header, Twist._full_text.count("MSG: "), Header._type)
buff = io.BytesIO()
twist.serialize(buff)
print(len(buff.getvalue()), Twist().deserialize(buff.getvalue()) == twist)
print(isinstance(twist, genpy.Message), isinstance(twist, rospy.Message), issubclass(Twist, genpy.Message))
print(Twist, Twist.__module__, Pose().orientation.w)
try:
    Twist().deserialize(b"short")
except genpy.DeserializationError as e:
    print("DeserializationError")
try:
    hash(twist)
except TypeError as e:
    print(e)
print(
    genpy.message.get_message_class("std_msgs/String") is String,
    genpy.message.get_message_class("no_such/Type"),
)
message = Twist()
genpy.message.fill_message_args(message, [{"linear": {"x": 2.5}}])
print(message.linear.x, genpy.message.strify_message(Point(1, 2, 3), indent="  "))
print(genpy.message.strify_message(twist, field_filter=lambda m: [s for s in m.__slots__ if s != "angular"]))
print([n for n in dir(rospy) if n.startswith("log")])


class Named(Twist):
    def __init__(self, name):
        super(Named, self).__init__(linear=Vector3(5, 0, 0))


print(Named("x").linear.x)
