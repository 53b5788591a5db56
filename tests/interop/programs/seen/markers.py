"""Markers: namespaces, ids, colours, lifetimes, lists of points, deleting."""

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import InteractiveMarkerFeedback, Marker, MarkerArray

rospy.init_node("markers")
pub = rospy.Publisher("markers", MarkerArray, queue_size=5, latch=True)
single = rospy.Publisher("marker", Marker, queue_size=5, latch=True)
shown = {}


def on_markers(msg):
    for m in msg.markers:
        if m.action == Marker.DELETEALL:
            shown.clear()
        elif m.action == Marker.DELETE:
            shown.pop((m.ns, m.id), None)
        else:
            shown[(m.ns, m.id)] = (m.type, round(m.color.a, 3), m.lifetime.to_sec(), len(m.points), m.text)
    batches.append(len(msg.markers))


batches = []
rospy.Subscriber("markers", MarkerArray, on_markers)
while not pub.get_num_connections():
    rospy.sleep(0.02)
array = MarkerArray()
for i, kind in enumerate((Marker.CUBE, Marker.LINE_STRIP, Marker.TEXT_VIEW_FACING, Marker.ARROW)):
    marker = Marker(
        header=Header(frame_id="map"), ns="shapes", id=i, type=kind, action=Marker.ADD, text="t%d" % i
    )
    marker.pose = Pose(Point(i, 0, 0), Quaternion(0, 0, 0, 1))
    marker.scale = Vector3(x=0.1, y=0.1, z=0.1)
    marker.color = ColorRGBA(1.0, 0.5, 0.0, 1.0 / (i + 1))
    marker.lifetime = rospy.Duration(i)
    marker.points = [Point(x=j) for j in range(i)]
    marker.colors = [marker.color] * i
    array.markers.append(marker)
steps = [
    array,
    MarkerArray([Marker(ns="shapes", id=1, action=Marker.DELETE)]),
    MarkerArray(markers=[Marker(action=3)]),
]
for i, step in enumerate(steps):
    pub.publish(step)
    while len(batches) <= i:
        rospy.sleep(0.01)
    print(batches, sorted(shown.items()))
single.publish(array.markers[3])
got = rospy.wait_for_message("marker", Marker, 20)
print(got.color, got.points[1:], got.mesh_use_embedded_materials, round(got.scale.x, 6), got.frame_locked)
print(Marker.MODIFY, Marker.SPHERE_LIST, InteractiveMarkerFeedback.MENU_SELECT, len(Marker._full_text) > 2000)
