"""image_geometry: pixels and rays of cameras, from their CameraInfo (wiki.ros.org/image_geometry).

OpenCV is needed only to remove lens distortion.
"""

import copy
import math

import numpy


def mkmat(rows, cols, L):
    """A matrix of numbers, row by row."""
    return numpy.asmatrix(numpy.array(L, dtype="float64").reshape(rows, cols))


def _over(value, depth):
    return float("inf") if depth == 0 else value / depth


class PinholeCameraModel:
    """One camera. Pixels are (u, v), points (x, y, z) in the camera's optical frame."""

    def __init__(self):
        self.K = self.D = self.R = self.P = self.full_K = self.full_P = None
        self.width = self.height = self.binning_x = self.binning_y = None
        self.raw_roi = self.tf_frame = self.stamp = None

    def fromCameraInfo(self, msg):
        """Take a CameraInfo; K and P are those of its binned region."""
        self.K, self.full_K = mkmat(3, 3, msg.K), mkmat(3, 3, msg.K)
        self.P, self.full_P = mkmat(3, 4, msg.P), mkmat(3, 4, msg.P)
        self.R = mkmat(3, 3, msg.R)
        self.D = mkmat(len(msg.D), 1, msg.D) if len(msg.D) else None
        self.width, self.height = self.resolution = msg.width, msg.height
        self.binning_x, self.binning_y = max(1, msg.binning_x), max(1, msg.binning_y)
        roi = self.raw_roi = copy.copy(msg.roi)
        if not (roi.x_offset or roi.y_offset or roi.width or roi.height):  # zeros mean the whole image
            roi.width, roi.height = self.width, self.height
        self.tf_frame, self.stamp = msg.header.frame_id, msg.header.stamp
        for matrix in (self.K, self.P):
            for i, (offset, binning) in enumerate(
                ((roi.x_offset, self.binning_x), (roi.y_offset, self.binning_y))
            ):
                matrix[i, i] /= binning
                matrix[i, 2] = (matrix[i, 2] - offset) / binning

    def rectifyImage(self, raw, rectified):
        """Write the image without lens distortion into `rectified`."""
        import cv2

        self.mapx = numpy.ndarray((self.height, self.width, 1), dtype="float32")
        self.mapy = numpy.ndarray((self.height, self.width, 1), dtype="float32")
        size = (self.width, self.height)
        cv2.initUndistortRectifyMap(self.K, self.D, self.R, self.P, size, cv2.CV_32FC1, self.mapx, self.mapy)
        cv2.remap(raw, self.mapx, self.mapy, cv2.INTER_CUBIC, rectified)

    def rectifyPoint(self, uv_raw):
        """The position of a pixel without lens distortion."""
        import cv2

        point = numpy.array(uv_raw, dtype="float64").reshape(1, 1, 2)
        return cv2.undistortPoints(point, self.K, self.D, R=self.R, P=self.P)[0, 0]

    def project3dToPixel(self, point):
        """The pixel that shows a point; NaN for a point in the camera's own plane."""
        x, y, w = numpy.dot(numpy.asarray(self.P), (point[0], point[1], point[2], 1.0)).tolist()
        return (x / w, y / w) if w != 0 else (float("nan"), float("nan"))

    def projectPixelTo3dRay(self, uv):
        """The direction in which a pixel looks, of length 1."""
        x, y = (uv[0] - self.cx()) / self.fx(), (uv[1] - self.cy()) / self.fy()
        length = math.sqrt(x * x + y * y + 1)
        return x / length, y / length, 1.0 / length

    def getDeltaU(self, deltaX, Z):
        """Pixels to the right for metres to the right, at a depth."""
        return _over(self.fx() * deltaX, Z)

    def getDeltaV(self, deltaY, Z):
        """Pixels down for metres down, at a depth."""
        return _over(self.fy() * deltaY, Z)

    def getDeltaX(self, deltaU, Z):
        """Metres to the right for pixels to the right, at a depth."""
        return Z * deltaU / self.fx()

    def getDeltaY(self, deltaV, Z):
        """Metres down for pixels down, at a depth."""
        return Z * deltaV / self.fy()

    def fovX(self):
        """Angle of view from left to right, radians."""
        return 2 * math.atan(self.width / (2 * self.fx()))

    def fovY(self):
        """Angle of view from top to bottom, radians."""
        return 2 * math.atan(self.height / (2 * self.fy()))

    def fullResolution(self):
        """(width, height)."""
        return self.resolution

    def tfFrame(self):
        """The optical frame's name."""
        return self.tf_frame

    def _number(row, column, what):
        def number(self):
            return self.P[row, column]

        number.__doc__ = what
        return number

    fx, fy = _number(0, 0, "Focal length, pixels."), _number(1, 1, "Focal length, pixels.")
    cx, cy = _number(0, 2, "The image's middle, pixels."), _number(1, 2, "The image's middle, pixels.")
    Tx, Ty = _number(0, 3, "Shift of a right camera."), _number(1, 3, "Shift of a lower camera.")

    def _matrix(name, what):
        def matrix(self):
            return getattr(self, name)

        matrix.__doc__ = what
        return matrix

    intrinsicMatrix = _matrix("K", "K of the binned region.")
    distortionCoeffs = _matrix("D", "D; None when there is none.")
    rotationMatrix = _matrix("R", "R.")
    projectionMatrix = _matrix("P", "P of the binned region.")
    fullIntrinsicMatrix = _matrix("full_K", "K of the whole image.")
    fullProjectionMatrix = _matrix("full_P", "P of the whole image.")


class StereoCameraModel:
    """Two cameras side by side."""

    def __init__(self):
        self.left, self.right = PinholeCameraModel(), PinholeCameraModel()

    def fromCameraInfo(self, left_msg, right_msg):
        """Take both CameraInfos."""
        self.left.fromCameraInfo(left_msg)
        self.right.fromCameraInfo(right_msg)
        p = self.right.P
        self.Q = numpy.zeros((4, 4))
        self.Q[0, 0] = self.Q[1, 1] = 1.0
        self.Q[0, 3], self.Q[1, 3], self.Q[2, 3] = -p[0, 2], -p[1, 2], p[0, 0]
        self.Q[3, 2] = p[0, 0] / -p[0, 3]

    def tfFrame(self):
        """The left camera's optical frame."""
        return self.left.tfFrame()

    def project3dToPixel(self, point):
        """The pixels that show a point, in both cameras."""
        return self.left.project3dToPixel(point), self.right.project3dToPixel(point)

    def projectPixelTo3d(self, left_uv, disparity):
        """The point that the left pixel sees when the right one is so many pixels off; zeros for infinity."""
        x, y, z, w = numpy.dot(self.Q, (left_uv[0], left_uv[1], disparity, 1.0)).tolist()
        return (x / w, y / w, z / w) if w != 0 else (0.0, 0.0, 0.0)

    def getZ(self, disparity):
        """Depth of a disparity, metres."""
        return _over(-self.right.P[0, 3], disparity)

    def getDisparity(self, Z):
        """Disparity of a depth, pixels."""
        return _over(-self.right.P[0, 3], Z)
