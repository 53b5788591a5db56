# ruff: noqa: B905
"""Messages to dictionaries and back, by their slots, as bridges to JSON do it; classes by name."""

import base64
import json

import genpy
import roslib.message
import rospy


def to_dict(message):
    if isinstance(message, genpy.Message):
        kinds = zip(message.__slots__, message._slot_types)
        return {name: to_dict_field(getattr(message, name), kind) for name, kind in kinds}
    return message


def to_dict_field(value, kind):
    if isinstance(value, (genpy.Time, genpy.Duration)):
        return {"secs": value.secs, "nsecs": value.nsecs}
    if kind.startswith("uint8["):
        return base64.b64encode(bytes(value)).decode()
    if isinstance(value, (list, tuple)):
        return [to_dict(item) for item in value]
    return to_dict(value)


for name in ("geometry_msgs/PoseStamped", "std_msgs/Header", "sensor_msgs/Image", "std_msgs/UInt8MultiArray",
             "nav_msgs/Path", "actionlib_msgs/GoalStatusArray", "visualization_msgs/Marker", "std_msgs/Time"):  # fmt: skip
    message = roslib.message.get_message_class(name)()
    print(name, json.dumps(to_dict(message), sort_keys=True))
print(
    roslib.message.get_message_class("no_pkg_msgs/Thing"),
    roslib.message.get_message_class("std_msgs/Nothing"),
)
service = roslib.message.get_service_class("nav_msgs/GetPlan")
print(
    service.__name__,
    service._type,
    service._request_class.__slots__,
    service._response_class._type,
    service._md5sum,
)
print(roslib.message.get_service_class("std_srvs/Nothing"))
pose = roslib.message.get_message_class("geometry_msgs/PoseStamped")()
genpy.message.fill_message_args(
    pose, [{"header": {"frame_id": "map", "stamp": 0}, "pose": {"position": {"x": 1.5}}}]
)
print(pose.pose.position.x, pose.header.frame_id, pose.header.stamp)
genpy.message.fill_message_args(pose, [[1, {"secs": 3, "nsecs": 4}, "odom"], [[1, 2, 3], [0, 0, 0, 1]]])
print(pose.header.seq, pose.header.stamp, pose.pose.position.z, pose.pose.orientation.w)
for wrong in ([{"no_field": 1}], [1, 2, 3], {"header": 5}, [{"pose": {"position": 3}}]):
    try:
        genpy.message.fill_message_args(
            roslib.message.get_message_class("geometry_msgs/PoseStamped")(), wrong
        )
    except Exception as e:
        print(type(e).__name__, str(e)[:50].split(" [")[0])
keys = {"now": rospy.Time(9, 5)}
genpy.message.fill_message_args(pose, [{"header": "auto" if False else {"stamp": "now"}}], keys=keys)
print(pose.header.stamp)
print(genpy.message.strify_message(pose, field_filter=lambda m: [f for f in m.__slots__ if f != "seq"]))
print(genpy.message.get_printable_message_args(pose)[:60].split("\n")[0])
