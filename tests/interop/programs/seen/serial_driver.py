"""A driver's skeleton: frames with checksums from a byte stream, reconnecting, a reader thread and publishers."""

import queue
import struct
import threading

import rospy
from geometry_msgs.msg import Vector3Stamped
from sensor_msgs.msg import Imu, Temperature
from std_srvs.srv import Trigger, TriggerResponse


def frame(kind, *values):
    body = struct.pack("<B%df" % len(values), kind, *values)
    return b"\xaa\x55" + bytes([len(body)]) + body + bytes([sum(body) & 0xFF])


class Port:
    def __init__(self, chunks):
        self.chunks = queue.Queue()
        for chunk in chunks:
            self.chunks.put(chunk)

    def read(self):
        return self.chunks.get(timeout=0.2)


class Driver:
    def __init__(self, port):
        self.port, self.buffer, self.bad = port, b"", 0
        self.imu = rospy.Publisher("imu/data", Imu, queue_size=20)
        self.temperature = rospy.Publisher("temperature", Temperature, queue_size=20)
        self.vector = rospy.Publisher("vector", Vector3Stamped, queue_size=20)
        rospy.Service("~statistics", Trigger, self.statistics)
        self.thread = threading.Thread(target=self.run, name="reader")
        self.thread.daemon = True

    def statistics(self, _):
        return TriggerResponse(True, "bad: %d" % self.bad)

    def run(self):
        while not rospy.is_shutdown():
            try:
                self.buffer += self.port.read()
            except queue.Empty:
                break
            while len(self.buffer) >= 4:
                if self.buffer[:2] != b"\xaa\x55":
                    self.buffer = self.buffer[1:]
                    continue
                size = self.buffer[2]
                if len(self.buffer) < size + 4:
                    break
                body, check = self.buffer[3 : 3 + size], self.buffer[3 + size]
                self.buffer = self.buffer[4 + size :]
                if sum(body) & 0xFF != check:
                    self.bad += 1
                    rospy.logwarn_throttle(60, "bad checksum")
                    continue
                self.dispatch(body[0], struct.unpack("<%df" % ((size - 1) // 4), body[1:]))

    def dispatch(self, kind, values):
        if kind == 1:
            msg = Imu()
            msg.header.stamp, msg.header.frame_id = rospy.Time.now(), "imu"
            msg.orientation_covariance[0] = -1
            msg.angular_velocity.x, msg.angular_velocity.y, msg.angular_velocity.z = values[:3]
            msg.linear_acceleration.z = values[3]
            self.imu.publish(msg)
        elif kind == 2:
            self.temperature.publish(temperature=values[0], variance=0.5)
        else:
            msg = Vector3Stamped()
            msg.vector.x = len(values)
            self.vector.publish(msg)


rospy.init_node("serial_driver")
stream = (
    frame(1, 0.5, 0.25, -1, 9.75)
    + b"noise"
    + frame(2, 36.5)
    + frame(2, 1)[:-1]
    + b"\x00"
    + frame(3)
    + frame(2, 37)
)
driver = Driver(Port([stream[i : i + 7] for i in range(0, len(stream), 7)]))
got = []
for topic, kind in (("imu/data", Imu), ("temperature", Temperature), ("vector", Vector3Stamped)):
    rospy.Subscriber(topic, kind, got.append)
while not all(p.get_num_connections() for p in (driver.imu, driver.temperature, driver.vector)):
    rospy.sleep(0.02)
driver.thread.start()
driver.thread.join(10)
while len(got) < 4:
    rospy.sleep(0.02)
for msg in sorted(got, key=lambda m: (type(m).__name__, m.header.seq)):
    if isinstance(msg, Imu):
        print(
            msg.angular_velocity.z, msg.linear_acceleration.z, msg.orientation_covariance, msg.header.frame_id
        )
    else:
        print(type(msg).__name__, getattr(msg, "temperature", None), msg.header.seq, msg.header.stamp)
print(rospy.ServiceProxy("~statistics", Trigger)().message, driver.thread.daemon)
