"""Images without OpenCV: rows and steps, cropping, compressing, a CompressedImage relay, camera info beside it."""

import zlib

import rospy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, RegionOfInterest

rospy.init_node("image_pipe")
raw = rospy.Publisher("image_raw", Image, queue_size=2)
small = rospy.Publisher("image_raw/compressed", CompressedImage, queue_size=2)
info = rospy.Publisher("camera_info", CameraInfo, queue_size=2, latch=True)
results = []


def on_image(msg, wanted):
    assert msg.step == msg.width * 3, msg.step
    rows = [msg.data[y * msg.step : (y + 1) * msg.step] for y in range(msg.height)]
    crop = b"".join(row[3:9] for row in rows[1:3])
    out = CompressedImage(header=msg.header, format="zlib; " + msg.encoding)
    out.data = zlib.compress(crop)
    small.publish(out)
    results.append((type(msg.data).__name__, len(msg.data), msg.encoding, wanted, msg.is_bigendian))


def on_small(msg):
    results.append((msg.format, list(zlib.decompress(msg.data)), msg.header.frame_id, msg.header.seq))


rospy.Subscriber("image_raw", Image, on_image, callback_args="crop", queue_size=1, buff_size=2**24)
rospy.Subscriber("image_raw/compressed", CompressedImage, on_small)
camera = CameraInfo(width=4, height=4, roi=RegionOfInterest(width=2, height=2, do_rectify=True))
camera.K[0] = camera.K[4] = 525.0
camera.P = [1.0] * 12
info.publish(camera)
while not (raw.get_num_connections() and small.get_num_connections()):
    rospy.sleep(0.02)
image = Image(width=4, height=4, encoding="rgb8", step=12, data=bytes(range(48)))
image.header.frame_id = "camera"
for i, data in enumerate((bytes(range(48)), bytearray(range(48))[::-1], [7] * 48, tuple(range(48)))):
    image.data = bytes(data)
    raw.publish(image)
    while len(results) < 2 * i + 2:
        rospy.sleep(0.01)
for result in sorted(results, key=str):
    print(result)
got = rospy.wait_for_message("camera_info", CameraInfo, 20)
print(type(got.K), got.K[0], got.P[3], type(got.D), got.D, got.roi.do_rectify, got.R == (0.0,) * 9)
print(str(image).splitlines()[-1][:40], len(str(image)))
