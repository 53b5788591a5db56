"""sensor_msgs.point_cloud2 by random clouds, without a node: `clouds_random.py SEED CASES` prints all."""

import random
import struct
import sys

from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 8: 8}
NAMES = ["x", "y", "z", "intensity", "ring", "rgb", "t"]


def fields(odd):
    made, offset = [], 0
    for name in draw.sample(NAMES, draw.randint(1, 5)):
        datatype, count = draw.randint(1, 8), draw.choice([1, 1, 1, 2, 3, 0])
        offset += draw.choice([0, 0, 0, 1, 3, 4])
        if odd and draw.random() < 0.1:
            offset = max(0, offset - draw.randint(1, 6))  # overlaps the one before
        made.append(PointField(name, offset, datatype, count))
        offset += SIZES[datatype] * count
    if odd and draw.random() < 0.3:
        draw.shuffle(made)
    return made, offset


def octets(count):
    """Random bytes, in which NaN, infinity and whole floats occur."""
    pieces = [struct.pack(draw.choice("<>") + "f", draw.choice([1.5, -2.0, float("nan"), float("inf"), 0.0]))]
    pieces += [bytes(draw.randrange(256) for _ in range(4)) for _ in range(2)]
    return b"".join(draw.choice(pieces) for _ in range(count // 4 + 1))[:count]


def cloud():
    made, size = fields(odd=True)
    step = size + draw.choice([0, 0, 1, 5, 16])
    height, width = draw.choice([1, 1, 2, 3]), draw.randint(0, 5)
    row = step * width + draw.choice([0, 0, 7])
    data = octets(row * height + draw.choice([0, 0, 0, 0, 4, -1]))
    return PointCloud2(
        Header(), height, width, made, draw.random() < 0.4, step, row, data, draw.random() < 0.5
    )


def shown(function):
    try:
        print("  ", repr(function()))
    except Exception as error:
        print("  ", type(error).__name__, error)


def read():
    given = cloud()
    names = [field.name for field in given.fields]
    wanted = draw.choice([None, None, names[:1], tuple(names[::-1]), {*names[:2]}, "xyz", ["nothing"], []])
    nans, uvs = draw.random() < 0.5, []
    if given.width and draw.random() < 0.3:
        uvs = [(draw.randrange(given.width), draw.randrange(given.height + 1)) for _ in range(3)]
    print(
        "read",
        given.width,
        given.height,
        given.is_bigendian,
        given.point_step,
        sorted(wanted or ()),
        nans,
        uvs,
    )
    shown(lambda: list(point_cloud2.read_points(given, wanted, nans, uvs)))
    shown(lambda: list(point_cloud2.read_points(given, field_names=wanted, skip_nans=nans)))
    if not isinstance(wanted, set):
        shown(lambda: point_cloud2.read_points_list(given, wanted, nans, uvs))


def value(datatype):
    if datatype >= 7:
        return draw.choice([0, 1, -2.5, 1e30, float("nan"), 1e300])
    return draw.choice([0, 1, 100, 127, 127, -1, 255, 70000, 1.0])


def create():
    made, _ = fields(odd=draw.random() < 0.5)
    count = sum(field.count for field in made) + draw.choice([0, 0, 0, 0, 1, -1])
    kinds = [field.datatype for field in sorted(made, key=lambda f: f.offset) for _ in range(field.count)]
    points = [[value([*kinds, 7][i]) for i in range(max(0, count)) if i <= len(kinds)] for _ in range(3)]
    print("create", [(f.offset, f.datatype, f.count) for f in made], points)
    shown(lambda: point_cloud2.create_cloud(Header(frame_id="f"), made, points))
    shown(lambda: point_cloud2.create_cloud_xyz32(Header(frame_id="f"), [point[:3] for point in points]))


draw = random.Random(int(sys.argv[1]))
for _ in range(int(sys.argv[2])):
    read()
    create()
shown(lambda: list(point_cloud2.read_points("no cloud")))
