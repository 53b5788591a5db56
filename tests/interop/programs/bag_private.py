"""What programs take from a bag beside its public methods, and what they overwrite in a subclass."""

import io
import os
import pickle
import sys
import tempfile

import rosbag
import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Float64, String

os.chdir(tempfile.mkdtemp())
sys.stderr = io.StringIO()  # warnings differ in their words
with rosbag.Bag("run.bag", "w", chunk_threshold=300) as bag:
    bag.set_encryptor()
    for i in range(20):
        bag.write("/said", String("x" * i), rospy.Time(100 + i))
        bag.write("/number", Float64(i), rospy.Time(100 + i * 2, 5))
    bag.write("pose", PoseStamped(), rospy.Time(90))
    bag.flush()
    try:
        bag.set_encryptor()
    except rosbag.ROSBagException as error:
        print(error)

bag = rosbag.Bag("run.bag")
for one in sorted(bag._connections.values(), key=lambda one: one.id):
    print(one.id, one.topic, one.datatype, one.md5sum, bool(one.msg_def), sorted(one.header))
print(sum(count for chunk in bag._chunks for count in chunk.connection_counts.values()))
print(min(chunk.start_time for chunk in bag._chunks), max(chunk.end_time for chunk in bag._chunks))
print(
    [one.topic for one in bag._get_connections("said")],
    [one.topic for one in bag._get_connections(["/pose"])],
)
print([one.datatype for one in bag._get_connections(connection_filter=lambda topic, *_: topic != "/said")])
for entries in (
    list(bag._get_entries()),
    list(bag._get_entries(bag._get_connections("/number"), rospy.Time(105), rospy.Time(112))),
    [entry for _, index in sorted(bag._connection_indexes.items()) for entry in index],
):
    print([str(entry.time) for entry in entries])
    for entry in entries:
        assert entry.position == (entry.chunk_pos, entry.offset)
        topic, message, stamp = bag._read_message(entry.position)
        print(topic, repr(message), stamp == entry.time)
print(bag._filename, bag.filename, bag.mode, bag.version)
print(bag._uncompressed_size > 1000)

for _, message, _ in bag.read_messages("/said"):
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(message, protocol))
        assert (again, type(again)) == (message, type(message))


class Named(rosbag.Bag):
    """As public tools do."""

    @property
    def filename(self):
        return "named " + self._filename

    @property
    def mode(self):
        return self._mode.upper()

    version = property(lambda self: self._version / 100.0)


with Named("run.bag") as named:
    print(named.filename, named.mode, named.version, named.get_message_count())


def unusable(text):
    """A class whose definition cannot be used."""

    class Odd:
        _type, _md5sum, _full_text = "my_pkg/Odd", "a" * 32, text

    return Odd


for number, text in enumerate(("", 'syntax = "proto3";\nmessage Odd { int32 a = 1; }\n', "int32 a\n??? b\n")):
    name = "%d.bag" % number
    with rosbag.Bag(name, "w") as odd:
        odd.write("/good", String("before"), rospy.Time(1))
        odd.write(
            "/odd", ("my_pkg/Odd", b"\x01", chr(97 + number) * 32, unusable(text)), rospy.Time(2), raw=True
        )
        odd.write("/good", String("after"), rospy.Time(3))
    for topic, message, _ in rosbag.Bag(name):
        print(topic, type(message).__name__, message.__slots__)
