"""image_geometry, laser_geometry, angles: numbers out of messages; no node is needed."""

import math
import zlib

import angles
import numpy
import sensor_msgs.point_cloud2 as pc2
from image_geometry import PinholeCameraModel, StereoCameraModel
from laser_geometry import LaserProjection
from sensor_msgs.msg import CameraInfo, LaserScan


def rounded(value):
    """Beyond what machines differ in."""
    if isinstance(value, (tuple, list)):
        return tuple(rounded(one) for one in value)
    return round(float(value), 9) + 0.0 if isinstance(value, (float, int)) else value


info = CameraInfo(width=640, height=480, distortion_model="plumb_bob", D=[0.1, -0.2, 0, 0, 0])
info.header.frame_id = "optical"
info.K = [525.0, 0, 319.5, 0, 520.0, 239.5, 0, 0, 1]
info.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
info.P = [525.0, 0, 319.5, 0, 0, 520.0, 239.5, 0, 0, 0, 1, 0]
model = PinholeCameraModel()
for binning, region in ((0, (0, 0, 0, 0)), (2, (10, 20, 300, 200))):
    info.binning_x = info.binning_y = binning
    info.roi.x_offset, info.roi.y_offset, info.roi.width, info.roi.height = region
    model.fromCameraInfo(info)
    print(model.tfFrame(), model.fullResolution(), model.binning_x, model.raw_roi.width, info.roi.width)
    print(
        rounded(
            [
                model.fx(),
                model.fy(),
                model.cx(),
                model.cy(),
                model.Tx(),
                model.Ty(),
                model.fovX(),
                model.fovY(),
            ]
        )
    )
    for point in ((0.1, -0.2, 2.0), (0, 0, 1), (1, 2, 0), (5, 5, -3)):
        pixel = model.project3dToPixel(point)
        print(rounded(pixel), rounded(model.projectPixelTo3dRay(pixel)))
    print(
        rounded(
            [model.getDeltaU(0.1, 2), model.getDeltaV(0.1, 2), model.getDeltaX(5, 2), model.getDeltaY(5, 2)]
        )
    )
    print(model.getDeltaU(1, 0), model.getDeltaV(1, 0))
    for matrix in (model.intrinsicMatrix(), model.distortionCoeffs(), model.rotationMatrix(),
                   model.projectionMatrix(), model.fullIntrinsicMatrix(), model.fullProjectionMatrix()):  # fmt: skip
        print(matrix.shape, rounded(matrix.tolist()))
info.D = []
model.fromCameraInfo(info)
print(model.distortionCoeffs(), isinstance(model.K, numpy.matrix), (model.K * model.K.I).round(6).tolist())
right = CameraInfo(width=640, height=480, K=info.K, R=info.R, P=list(info.P))
right.P[3] = -63.0
stereo = StereoCameraModel()
stereo.fromCameraInfo(info, right)
print(stereo.tfFrame(), rounded(stereo.project3dToPixel((0.1, -0.2, 2.0))), rounded(stereo.Q.tolist()))
for disparity in (0, 3, 31.5):
    print(
        rounded(stereo.projectPixelTo3d((300, 200), disparity)),
        stereo.getZ(disparity),
        stereo.getDisparity(disparity),
    )

numpy.seterr(invalid="ignore")
scan = LaserScan(angle_min=-0.5, angle_increment=0.25, time_increment=0.001, range_min=0.2, range_max=4.0)
scan.angle_max = 0.5
scan.header.frame_id = "laser"
scan.ranges = [1.0, 0.1, float("inf"), 3.5, float("nan")]
projection = LaserProjection()
for intensities in ((), (1.0, 2.0, 3.0, 4.0, 5.0)):
    scan.intensities = list(intensities)
    for options in (LaserProjection.ChannelOption.DEFAULT, 0, 0x1F, 0x0C):
        for cutoff in (-1.0, 2.0, 9.0):
            cloud = projection.projectLaser(scan, range_cutoff=cutoff, channel_options=options)
            print(cloud.header.frame_id, cloud.point_step, cloud.width, [(f.name, f.offset, f.datatype) for f in cloud.fields],
                  [[round(v, 5) for v in point] for point in pc2.read_points(cloud)])  # fmt: skip
print(projection.projectLaser(scan).row_step, projection.projectLaser(LaserScan()).width)

steps = [-3.5, -math.pi, -2.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 2.0, math.pi, 4.0]
for a in steps:
    print(
        rounded([angles.normalize_angle(a), angles.normalize_angle_positive(a), angles.two_pi_complement(a)])
    )
for function in (
    angles.shortest_angular_distance_with_limits,
    angles.shortest_angular_distance_with_large_limits,
):
    for limits in (
        (-0.25, 0.25),
        (0.25, -0.25),
        (-math.pi, math.pi),
        (-2.0, 1.0),
        (1.0, -2.0),
        (-5.0, 6.0),
        (0.0, 0.0),
    ):
        found = [function(a, b, *limits) for a in steps for b in steps]
        texts = [
            "%s %.6f" % (valid, abs(turn) if abs(abs(turn) - math.pi) < 1e-9 else turn + 0.0)
            for valid, turn in found
        ]
        print(
            function.__name__[27:],
            limits,
            texts[::17],
            zlib.crc32("\n".join(texts).replace("-0.000000", "0.000000").encode()),
        )
