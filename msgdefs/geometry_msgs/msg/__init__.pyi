# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of geometry_msgs as classes."""

from collections.abc import Sequence as _Sequence

import msgdefs.std_msgs.msg as _std_msgs
from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from rosproto.codec import Message as _Message

class Accel(_Message):
    """geometry_msgs/Accel

    # An acceleration in free space.

    Vector3 linear   # m/s^2
    Vector3 angular  # rad/s^2
    """

    linear: Vector3
    angular: Vector3
    def __init__(
        self,
        linear: Vector3 = ...,
        angular: Vector3 = ...,
    ) -> None: ...

class AccelStamped(_Message):
    """geometry_msgs/AccelStamped

    # An acceleration in the frame and at the time of the header.

    Header header
    Accel accel
    """

    header: _std_msgs.Header
    accel: Accel
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        accel: Accel = ...,
    ) -> None: ...

class AccelWithCovariance(_Message):
    """geometry_msgs/AccelWithCovariance

    # An acceleration and how sure it is.

    Accel accel
    float64[36] covariance  # Row-major 6 x 6 covariance of linear, then angular acceleration.
    """

    accel: Accel
    covariance: _Float64Array
    def __init__(
        self,
        accel: Accel = ...,
        covariance: _Floats = ...,
    ) -> None: ...

class AccelWithCovarianceStamped(_Message):
    """geometry_msgs/AccelWithCovarianceStamped

    # An acceleration with covariance in the frame and at the time of the header.

    Header header
    AccelWithCovariance accel
    """

    header: _std_msgs.Header
    accel: AccelWithCovariance
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        accel: AccelWithCovariance = ...,
    ) -> None: ...

class Inertia(_Message):
    """geometry_msgs/Inertia

    # Mass, centre of mass and inertia tensor of a body.

    float64 m    # kg
    Vector3 com  # centre of mass, m
    float64 ixx  # tensor about the centre of mass, kg m^2
    float64 ixy
    float64 ixz
    float64 iyy
    float64 iyz
    float64 izz
    """

    m: float
    com: Vector3
    ixx: float
    ixy: float
    ixz: float
    iyy: float
    iyz: float
    izz: float
    def __init__(
        self,
        m: float = ...,
        com: Vector3 = ...,
        ixx: float = ...,
        ixy: float = ...,
        ixz: float = ...,
        iyy: float = ...,
        iyz: float = ...,
        izz: float = ...,
    ) -> None: ...

class InertiaStamped(_Message):
    """geometry_msgs/InertiaStamped

    Header header
    Inertia inertia
    """

    header: _std_msgs.Header
    inertia: Inertia
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        inertia: Inertia = ...,
    ) -> None: ...

class Point(_Message):
    """geometry_msgs/Point

    # A position, m.

    float64 x  # m
    float64 y  # m
    float64 z  # m
    """

    x: float
    y: float
    z: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        z: float = ...,
    ) -> None: ...

class Point32(_Message):
    """geometry_msgs/Point32

    # A position in single precision, m. For clouds and polygons, where size matters; else prefer
    # Point.

    float32 x  # m
    float32 y  # m
    float32 z  # m
    """

    x: float
    y: float
    z: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        z: float = ...,
    ) -> None: ...

class PointStamped(_Message):
    """geometry_msgs/PointStamped

    # A position in the frame and at the time of the header.

    Header header
    Point point
    """

    header: _std_msgs.Header
    point: Point
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        point: Point = ...,
    ) -> None: ...

class Polygon(_Message):
    """geometry_msgs/Polygon

    # An area: its corners in order, the last one joined to the first.

    Point32[] points  # m
    """

    points: list[Point32]
    def __init__(
        self,
        points: _Sequence[Point32] = ...,
    ) -> None: ...

class PolygonStamped(_Message):
    """geometry_msgs/PolygonStamped

    # A polygon in the frame and at the time of the header.

    Header header
    Polygon polygon
    """

    header: _std_msgs.Header
    polygon: Polygon
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        polygon: Polygon = ...,
    ) -> None: ...

class Pose(_Message):
    """geometry_msgs/Pose

    # Where something is and how it is turned.

    Point position          # m
    Quaternion orientation
    """

    position: Point
    orientation: Quaternion
    def __init__(
        self,
        position: Point = ...,
        orientation: Quaternion = ...,
    ) -> None: ...

class Pose2D(_Message):
    """geometry_msgs/Pose2D

    # A pose in the plane. Deprecated by ROS, but what the chassis publishes as /movebase_pose2d.

    float64 x      # m
    float64 y      # m
    float64 theta  # rad, counter-clockwise from the x axis
    """

    x: float
    y: float
    theta: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        theta: float = ...,
    ) -> None: ...

class PoseArray(_Message):
    """geometry_msgs/PoseArray

    # Poses that share one header.

    Header header
    Pose[] poses
    """

    header: _std_msgs.Header
    poses: list[Pose]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        poses: _Sequence[Pose] = ...,
    ) -> None: ...

class PoseStamped(_Message):
    """geometry_msgs/PoseStamped

    # A pose in the frame and at the time of the header.

    Header header
    Pose pose
    """

    header: _std_msgs.Header
    pose: Pose
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        pose: Pose = ...,
    ) -> None: ...

class PoseWithCovariance(_Message):
    """geometry_msgs/PoseWithCovariance

    # A pose and how sure it is.

    Pose pose

    # Row-major 6 x 6 covariance of (x, y, z, rotation about x, about y, about z); m and rad.
    float64[36] covariance
    """

    pose: Pose
    covariance: _Float64Array
    def __init__(
        self,
        pose: Pose = ...,
        covariance: _Floats = ...,
    ) -> None: ...

class PoseWithCovarianceStamped(_Message):
    """geometry_msgs/PoseWithCovarianceStamped

    # A pose with covariance in the frame and at the time of the header.

    Header header
    PoseWithCovariance pose
    """

    header: _std_msgs.Header
    pose: PoseWithCovariance
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        pose: PoseWithCovariance = ...,
    ) -> None: ...

class Quaternion(_Message):
    """geometry_msgs/Quaternion

    # An orientation as a unit quaternion; no rotation is (0, 0, 0, 1).

    float64 x
    float64 y
    float64 z
    float64 w
    """

    x: float
    y: float
    z: float
    w: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        z: float = ...,
        w: float = ...,
    ) -> None: ...

class QuaternionStamped(_Message):
    """geometry_msgs/QuaternionStamped

    # An orientation in the frame and at the time of the header.

    Header header
    Quaternion quaternion
    """

    header: _std_msgs.Header
    quaternion: Quaternion
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        quaternion: Quaternion = ...,
    ) -> None: ...

class Transform(_Message):
    """geometry_msgs/Transform

    # How one frame stands in another: rotate, then translate.

    Vector3 translation  # m
    Quaternion rotation
    """

    translation: Vector3
    rotation: Quaternion
    def __init__(
        self,
        translation: Vector3 = ...,
        rotation: Quaternion = ...,
    ) -> None: ...

class TransformStamped(_Message):
    """geometry_msgs/TransformStamped

    # Where the frame child_frame_id is in header.frame_id, at header.stamp.

    Header header          # frame_id is the parent
    string child_frame_id  # the frame that the transform places
    Transform transform
    """

    header: _std_msgs.Header
    child_frame_id: str
    transform: Transform
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        child_frame_id: str = ...,
        transform: Transform = ...,
    ) -> None: ...

class Twist(_Message):
    """geometry_msgs/Twist

    # A velocity in free space.

    Vector3 linear   # m/s
    Vector3 angular  # rad/s, about each axis
    """

    linear: Vector3
    angular: Vector3
    def __init__(
        self,
        linear: Vector3 = ...,
        angular: Vector3 = ...,
    ) -> None: ...

class TwistStamped(_Message):
    """geometry_msgs/TwistStamped

    # A velocity in the frame and at the time of the header.

    Header header
    Twist twist
    """

    header: _std_msgs.Header
    twist: Twist
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        twist: Twist = ...,
    ) -> None: ...

class TwistWithCovariance(_Message):
    """geometry_msgs/TwistWithCovariance

    # A velocity and how sure it is.

    Twist twist
    float64[36] covariance  # Row-major 6 x 6 covariance of (vx, vy, vz, wx, wy, wz); m/s and rad/s.
    """

    twist: Twist
    covariance: _Float64Array
    def __init__(
        self,
        twist: Twist = ...,
        covariance: _Floats = ...,
    ) -> None: ...

class TwistWithCovarianceStamped(_Message):
    """geometry_msgs/TwistWithCovarianceStamped

    # A velocity with covariance in the frame and at the time of the header.

    Header header
    TwistWithCovariance twist
    """

    header: _std_msgs.Header
    twist: TwistWithCovariance
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        twist: TwistWithCovariance = ...,
    ) -> None: ...

class Vector3(_Message):
    """geometry_msgs/Vector3

    # A free vector: it has a direction but no place, so only rotations apply to it.

    float64 x  # REP 103: forward
    float64 y  # left
    float64 z  # up
    """

    x: float
    y: float
    z: float
    def __init__(
        self,
        x: float = ...,
        y: float = ...,
        z: float = ...,
    ) -> None: ...

class Vector3Stamped(_Message):
    """geometry_msgs/Vector3Stamped

    # A vector in the frame and at the time of the header.

    Header header
    Vector3 vector
    """

    header: _std_msgs.Header
    vector: Vector3
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        vector: Vector3 = ...,
    ) -> None: ...

class Wrench(_Message):
    """geometry_msgs/Wrench

    # Force and torque on a body.

    Vector3 force   # N
    Vector3 torque  # N m
    """

    force: Vector3
    torque: Vector3
    def __init__(
        self,
        force: Vector3 = ...,
        torque: Vector3 = ...,
    ) -> None: ...

class WrenchStamped(_Message):
    """geometry_msgs/WrenchStamped

    # Force and torque in the frame and at the time of the header.

    Header header
    Wrench wrench
    """

    header: _std_msgs.Header
    wrench: Wrench
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        wrench: Wrench = ...,
    ) -> None: ...
