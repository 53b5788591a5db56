# ruff: noqa: RUF046
"""A map by topic and by service: cells to metres, saving as PGM, inflating, counting."""

import io
import math

import rospy
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, GetMapResponse

rospy.init_node("map_client")
grid = OccupancyGrid()
grid.header.frame_id = "map"
grid.info = MapMetaData(resolution=0.05, width=6, height=4)
grid.info.origin.position.x, grid.info.origin.orientation.w = -0.1, 1.0
grid.data = [-1, 0, 0, 100, 100, 0] * 4
pub = rospy.Publisher("map", OccupancyGrid, queue_size=1, latch=True)
pub.publish(grid)
rospy.Service("static_map", GetMap, lambda req: GetMapResponse(map=grid))
rospy.wait_for_service("static_map", timeout=5.0)
by_service = rospy.ServiceProxy("static_map", GetMap)().map
by_topic = rospy.wait_for_message("map", OccupancyGrid, timeout=20)
print(
    by_service.data == by_topic.data,
    type(by_topic.data),
    len(by_topic.data),
    by_topic.info == by_service.info,
)
print(by_topic.header.seq, by_service.header.seq, by_topic.header.frame_id)


def world_to_map(x, y, info):
    return int(math.floor((x - info.origin.position.x) / info.resolution)), int(
        (y - info.origin.position.y) / info.resolution
    )


print(world_to_map(0.06, 0.11, by_topic.info), round(by_topic.info.resolution, 4))
image = io.BytesIO()
image.write(b"P5\n# made\n%d %d\n255\n" % (by_topic.info.width, by_topic.info.height))
for y in range(by_topic.info.height - 1, -1, -1):
    row = by_topic.data[y * by_topic.info.width : (y + 1) * by_topic.info.width]
    image.write(bytes({-1: 205, 0: 254, 100: 0}[cell] for cell in row))
print(image.getvalue())
cells = list(by_topic.data)
inflated = cells[:]
for i, cell in enumerate(cells):
    if cell == 100:
        for j in (i - 1, i + 1):
            if 0 <= j < len(cells) and cells[j] == 0:
                inflated[j] = 50
by_topic.data = inflated
by_topic.header.stamp = rospy.Time(12, 5)
pub.publish(by_topic)
rospy.sleep(0.1)
got = rospy.wait_for_message("map", OccupancyGrid, timeout=20)
print(got.data, sum(1 for c in got.data if c > 0), got.header.stamp)
try:
    by_topic.data = [200]
    by_topic.serialize(io.BytesIO())
except Exception as e:
    print(type(e).__name__, e)
