# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of sensor_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from msgdefs._fields import Float32Array as _Float32Array
from msgdefs._fields import Float64Array as _Float64Array
from msgdefs._fields import Floats as _Floats
from msgdefs._fields import Int32Array as _Int32Array
from msgdefs._fields import Integers as _Integers
from msgdefs._fields import Octets as _Octets
from msgdefs._fields import UInt8Array as _UInt8Array
from rosproto.codec import Message as _Message
from rosproto.time import Time as _Time

class BatteryState(_Message):
    """sensor_msgs/BatteryState

    # State of a battery. NaN where a number is not measured.

    uint8 POWER_SUPPLY_STATUS_UNKNOWN=0
    uint8 POWER_SUPPLY_STATUS_CHARGING=1
    uint8 POWER_SUPPLY_STATUS_DISCHARGING=2
    uint8 POWER_SUPPLY_STATUS_NOT_CHARGING=3
    uint8 POWER_SUPPLY_STATUS_FULL=4
    uint8 POWER_SUPPLY_HEALTH_UNKNOWN=0
    uint8 POWER_SUPPLY_HEALTH_GOOD=1
    uint8 POWER_SUPPLY_HEALTH_OVERHEAT=2
    uint8 POWER_SUPPLY_HEALTH_DEAD=3
    uint8 POWER_SUPPLY_HEALTH_OVERVOLTAGE=4
    uint8 POWER_SUPPLY_HEALTH_UNSPEC_FAILURE=5
    uint8 POWER_SUPPLY_HEALTH_COLD=6
    uint8 POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE=7
    uint8 POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE=8
    uint8 POWER_SUPPLY_TECHNOLOGY_UNKNOWN=0
    uint8 POWER_SUPPLY_TECHNOLOGY_NIMH=1
    uint8 POWER_SUPPLY_TECHNOLOGY_LION=2
    uint8 POWER_SUPPLY_TECHNOLOGY_LIPO=3
    uint8 POWER_SUPPLY_TECHNOLOGY_LIFE=4
    uint8 POWER_SUPPLY_TECHNOLOGY_NICD=5
    uint8 POWER_SUPPLY_TECHNOLOGY_LIMN=6

    Header header
    float32 voltage                                   # V
    float32 temperature                               # degrees Celsius
    float32 current                                   # A, negative while discharging
    float32 charge                                    # A h left
    float32 capacity                                  # A h when full, as last seen
    float32 design_capacity                           # A h when new
    float32 percentage                                # 0 to 1
    uint8 power_supply_status                         # one of POWER_SUPPLY_STATUS_*
    uint8 power_supply_health                         # one of POWER_SUPPLY_HEALTH_*
    uint8 power_supply_technology                     # one of POWER_SUPPLY_TECHNOLOGY_*
    bool present                                      # a battery is inserted
    float32[] cell_voltage                            # V per cell, empty when unknown
    float32[] cell_temperature                        # degrees Celsius per cell, empty when unknown
    string location                                   # slot it sits in
    string serial_number                              # as far as known
    """

    POWER_SUPPLY_STATUS_UNKNOWN: _ClassVar[int] = 0
    POWER_SUPPLY_STATUS_CHARGING: _ClassVar[int] = 1
    POWER_SUPPLY_STATUS_DISCHARGING: _ClassVar[int] = 2
    POWER_SUPPLY_STATUS_NOT_CHARGING: _ClassVar[int] = 3
    POWER_SUPPLY_STATUS_FULL: _ClassVar[int] = 4
    POWER_SUPPLY_HEALTH_UNKNOWN: _ClassVar[int] = 0
    POWER_SUPPLY_HEALTH_GOOD: _ClassVar[int] = 1
    POWER_SUPPLY_HEALTH_OVERHEAT: _ClassVar[int] = 2
    POWER_SUPPLY_HEALTH_DEAD: _ClassVar[int] = 3
    POWER_SUPPLY_HEALTH_OVERVOLTAGE: _ClassVar[int] = 4
    POWER_SUPPLY_HEALTH_UNSPEC_FAILURE: _ClassVar[int] = 5
    POWER_SUPPLY_HEALTH_COLD: _ClassVar[int] = 6
    POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE: _ClassVar[int] = 7
    POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE: _ClassVar[int] = 8
    POWER_SUPPLY_TECHNOLOGY_UNKNOWN: _ClassVar[int] = 0
    POWER_SUPPLY_TECHNOLOGY_NIMH: _ClassVar[int] = 1
    POWER_SUPPLY_TECHNOLOGY_LION: _ClassVar[int] = 2
    POWER_SUPPLY_TECHNOLOGY_LIPO: _ClassVar[int] = 3
    POWER_SUPPLY_TECHNOLOGY_LIFE: _ClassVar[int] = 4
    POWER_SUPPLY_TECHNOLOGY_NICD: _ClassVar[int] = 5
    POWER_SUPPLY_TECHNOLOGY_LIMN: _ClassVar[int] = 6
    header: _std_msgs.Header
    voltage: float
    temperature: float
    current: float
    charge: float
    capacity: float
    design_capacity: float
    percentage: float
    power_supply_status: int
    power_supply_health: int
    power_supply_technology: int
    present: bool
    cell_voltage: _Float32Array
    cell_temperature: _Float32Array
    location: str
    serial_number: str
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        voltage: float = ...,
        temperature: float = ...,
        current: float = ...,
        charge: float = ...,
        capacity: float = ...,
        design_capacity: float = ...,
        percentage: float = ...,
        power_supply_status: int = ...,
        power_supply_health: int = ...,
        power_supply_technology: int = ...,
        present: bool = ...,
        cell_voltage: _Floats = ...,
        cell_temperature: _Floats = ...,
        location: str = ...,
        serial_number: str = ...,
    ) -> None: ...

class CameraInfo(_Message):
    """sensor_msgs/CameraInfo

    # Calibration of the camera whose images have the same stamp and frame.

    Header header
    uint32 height            # rows of the calibrated image
    uint32 width             # columns of it
    string distortion_model  # plumb_bob (5 parameters), rational_polynomial (8), equidistant (4)
    float64[] D              # distortion parameters, as many as the model has

    # Row-major 3 x 3 intrinsic matrix of the raw image: fx 0 cx, 0 fy cy, 0 0 1; pixels.
    float64[9] K
    float64[9] R             # Row-major 3 x 3 rectification rotation; identity for a single camera.

    # Row-major 3 x 4 projection of the rectified image: fx' 0 cx' Tx, 0 fy' cy' Ty, 0 0 1 0.
    float64[12] P
    uint32 binning_x         # columns combined into one; 0 and 1 are none
    uint32 binning_y         # rows combined into one
    RegionOfInterest roi     # part of the full image that is sent; all zeros means all of it
    """

    header: _std_msgs.Header
    height: int
    width: int
    distortion_model: str
    D: _Float64Array
    K: _Float64Array
    R: _Float64Array
    P: _Float64Array
    binning_x: int
    binning_y: int
    roi: RegionOfInterest
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        height: int = ...,
        width: int = ...,
        distortion_model: str = ...,
        D: _Floats = ...,
        K: _Floats = ...,
        R: _Floats = ...,
        P: _Floats = ...,
        binning_x: int = ...,
        binning_y: int = ...,
        roi: RegionOfInterest = ...,
    ) -> None: ...

class ChannelFloat32(_Message):
    """sensor_msgs/ChannelFloat32

    # One extra value for each point of a PointCloud.

    string name       # intensity, rgb, u, v ...
    float32[] values
    """

    name: str
    values: _Float32Array
    def __init__(
        self,
        name: str = ...,
        values: _Floats = ...,
    ) -> None: ...

class CompressedImage(_Message):
    """sensor_msgs/CompressedImage

    # An image as a file would hold it.

    Header header
    string format  # jpeg or png, sometimes with more after it
    uint8[] data   # the file's bytes
    """

    header: _std_msgs.Header
    format: str
    data: _UInt8Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        format: str = ...,
        data: _Octets = ...,
    ) -> None: ...

class FluidPressure(_Message):
    """sensor_msgs/FluidPressure

    # Absolute pressure of air or water.

    Header header
    float64 fluid_pressure  # Pa
    float64 variance        # 0 means unknown
    """

    header: _std_msgs.Header
    fluid_pressure: float
    variance: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        fluid_pressure: float = ...,
        variance: float = ...,
    ) -> None: ...

class Illuminance(_Message):
    """sensor_msgs/Illuminance

    # Illuminance of a surface.

    Header header
    float64 illuminance  # lx
    float64 variance     # 0 means unknown
    """

    header: _std_msgs.Header
    illuminance: float
    variance: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        illuminance: float = ...,
        variance: float = ...,
    ) -> None: ...

class Image(_Message):
    """sensor_msgs/Image

    # An uncompressed image.

    Header header       # frame_id: x right, y down, z into the picture
    uint32 height       # rows
    uint32 width        # columns
    string encoding     # pixel format: rgb8, bgr8, mono8, 16UC1 (depth in mm), 32FC1 (depth in m) ...
    uint8 is_bigendian  # of the data, where a value has several bytes
    uint32 step         # bytes per row
    uint8[] data        # step * height bytes, row by row
    """

    header: _std_msgs.Header
    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: _UInt8Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        height: int = ...,
        width: int = ...,
        encoding: str = ...,
        is_bigendian: int = ...,
        step: int = ...,
        data: _Octets = ...,
    ) -> None: ...

class Imu(_Message):
    """sensor_msgs/Imu

    # Inertial measurement. In each covariance: all 0 means unknown, first element -1 means the
    # quantity is not measured.

    Header header
    geometry_msgs/Quaternion orientation       # from the world frame
    float64[9] orientation_covariance          # row-major 3 x 3 about x, y, z, rad^2
    geometry_msgs/Vector3 angular_velocity     # rad/s
    float64[9] angular_velocity_covariance     # row-major 3 x 3 about x, y, z
    geometry_msgs/Vector3 linear_acceleration  # m/s^2, gravity included
    float64[9] linear_acceleration_covariance  # row-major 3 x 3 along x, y, z
    """

    header: _std_msgs.Header
    orientation: _geometry_msgs.Quaternion
    orientation_covariance: _Float64Array
    angular_velocity: _geometry_msgs.Vector3
    angular_velocity_covariance: _Float64Array
    linear_acceleration: _geometry_msgs.Vector3
    linear_acceleration_covariance: _Float64Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        orientation: _geometry_msgs.Quaternion = ...,
        orientation_covariance: _Floats = ...,
        angular_velocity: _geometry_msgs.Vector3 = ...,
        angular_velocity_covariance: _Floats = ...,
        linear_acceleration: _geometry_msgs.Vector3 = ...,
        linear_acceleration_covariance: _Floats = ...,
    ) -> None: ...

class JointState(_Message):
    """sensor_msgs/JointState

    # State of joints. The arrays are as long as name, or empty when not known.

    Header header
    string[] name
    float64[] position  # rad or m
    float64[] velocity  # rad/s or m/s
    float64[] effort    # N m or N
    """

    header: _std_msgs.Header
    name: list[str]
    position: _Float64Array
    velocity: _Float64Array
    effort: _Float64Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        name: _Sequence[str] = ...,
        position: _Floats = ...,
        velocity: _Floats = ...,
        effort: _Floats = ...,
    ) -> None: ...

class Joy(_Message):
    """sensor_msgs/Joy

    # Axes and buttons of a joystick.

    Header header
    float32[] axes   # -1 to 1
    int32[] buttons  # 1 pressed, 0 not
    """

    header: _std_msgs.Header
    axes: _Float32Array
    buttons: _Int32Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        axes: _Floats = ...,
        buttons: _Integers = ...,
    ) -> None: ...

class JoyFeedback(_Message):
    """sensor_msgs/JoyFeedback

    # Something for the joystick to do.

    uint8 TYPE_LED=0
    uint8 TYPE_RUMBLE=1
    uint8 TYPE_BUZZER=2

    uint8 type           # TYPE_LED, TYPE_RUMBLE or TYPE_BUZZER
    uint8 id             # which one of that type
    float32 intensity    # 0 to 1
    """

    TYPE_LED: _ClassVar[int] = 0
    TYPE_RUMBLE: _ClassVar[int] = 1
    TYPE_BUZZER: _ClassVar[int] = 2
    type: int
    id: int
    intensity: float
    def __init__(
        self,
        type: int = ...,
        id: int = ...,
        intensity: float = ...,
    ) -> None: ...

class JoyFeedbackArray(_Message):
    """sensor_msgs/JoyFeedbackArray

    # Several things for the joystick to do.

    JoyFeedback[] array
    """

    array: list[JoyFeedback]
    def __init__(
        self,
        array: _Sequence[JoyFeedback] = ...,
    ) -> None: ...

class LaserEcho(_Message):
    """sensor_msgs/LaserEcho

    # All echoes of one ray.

    float32[] echoes  # m, or intensities
    """

    echoes: _Float32Array
    def __init__(
        self,
        echoes: _Floats = ...,
    ) -> None: ...

class LaserScan(_Message):
    """sensor_msgs/LaserScan

    # One sweep of a planar laser range-finder. Angles are in the plane of the frame, 0 is forward
    # (x), counter-clockwise positive.

    Header header            # stamp is the time of the first ray
    float32 angle_min        # angle of the first ray, rad
    float32 angle_max        # angle of the last ray, rad
    float32 angle_increment  # rad from ray to ray
    float32 time_increment   # s from ray to ray, 0 when all are taken at once
    float32 scan_time        # s from sweep to sweep
    float32 range_min        # m; shorter ranges are not valid
    float32 range_max        # m; longer ranges are not valid
    float32[] ranges         # m, one per ray; outside range_min to range_max means no measurement
    float32[] intensities    # one per ray, device specific; empty when there are none
    """

    header: _std_msgs.Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: _Float32Array
    intensities: _Float32Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        angle_min: float = ...,
        angle_max: float = ...,
        angle_increment: float = ...,
        time_increment: float = ...,
        scan_time: float = ...,
        range_min: float = ...,
        range_max: float = ...,
        ranges: _Floats = ...,
        intensities: _Floats = ...,
    ) -> None: ...

class MagneticField(_Message):
    """sensor_msgs/MagneticField

    # A magnetic field measured in the frame of the header.

    Header header
    geometry_msgs/Vector3 magnetic_field  # T; NaN where an axis is not measured
    float64[9] magnetic_field_covariance  # row-major 3 x 3; all 0 means unknown
    """

    header: _std_msgs.Header
    magnetic_field: _geometry_msgs.Vector3
    magnetic_field_covariance: _Float64Array
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        magnetic_field: _geometry_msgs.Vector3 = ...,
        magnetic_field_covariance: _Floats = ...,
    ) -> None: ...

class MultiDOFJointState(_Message):
    """sensor_msgs/MultiDOFJointState

    # State of joints with several degrees of freedom, each array as long as joint_names or empty.

    Header header
    string[] joint_names
    geometry_msgs/Transform[] transforms
    geometry_msgs/Twist[] twist
    geometry_msgs/Wrench[] wrench
    """

    header: _std_msgs.Header
    joint_names: list[str]
    transforms: list[_geometry_msgs.Transform]
    twist: list[_geometry_msgs.Twist]
    wrench: list[_geometry_msgs.Wrench]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        joint_names: _Sequence[str] = ...,
        transforms: _Sequence[_geometry_msgs.Transform] = ...,
        twist: _Sequence[_geometry_msgs.Twist] = ...,
        wrench: _Sequence[_geometry_msgs.Wrench] = ...,
    ) -> None: ...

class MultiEchoLaserScan(_Message):
    """sensor_msgs/MultiEchoLaserScan

    # One sweep of a laser range-finder that returns several echoes per ray; see LaserScan.

    Header header
    float32 angle_min        # rad
    float32 angle_max        # rad
    float32 angle_increment  # rad
    float32 time_increment   # s
    float32 scan_time        # s
    float32 range_min        # m
    float32 range_max        # m
    LaserEcho[] ranges
    LaserEcho[] intensities
    """

    header: _std_msgs.Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: list[LaserEcho]
    intensities: list[LaserEcho]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        angle_min: float = ...,
        angle_max: float = ...,
        angle_increment: float = ...,
        time_increment: float = ...,
        scan_time: float = ...,
        range_min: float = ...,
        range_max: float = ...,
        ranges: _Sequence[LaserEcho] = ...,
        intensities: _Sequence[LaserEcho] = ...,
    ) -> None: ...

class NavSatFix(_Message):
    """sensor_msgs/NavSatFix

    # A position from satellites, WGS 84.

    uint8 COVARIANCE_TYPE_UNKNOWN=0
    uint8 COVARIANCE_TYPE_APPROXIMATED=1
    uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2
    uint8 COVARIANCE_TYPE_KNOWN=3

    Header header                           # frame_id is the antenna
    NavSatStatus status
    float64 latitude                        # degrees, north positive
    float64 longitude                       # degrees, east positive
    float64 altitude                        # m above the ellipsoid, NaN when unknown
    float64[9] position_covariance          # row-major 3 x 3 of east, north, up; m^2
    uint8 position_covariance_type          # one of COVARIANCE_TYPE_*
    """

    COVARIANCE_TYPE_UNKNOWN: _ClassVar[int] = 0
    COVARIANCE_TYPE_APPROXIMATED: _ClassVar[int] = 1
    COVARIANCE_TYPE_DIAGONAL_KNOWN: _ClassVar[int] = 2
    COVARIANCE_TYPE_KNOWN: _ClassVar[int] = 3
    header: _std_msgs.Header
    status: NavSatStatus
    latitude: float
    longitude: float
    altitude: float
    position_covariance: _Float64Array
    position_covariance_type: int
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        status: NavSatStatus = ...,
        latitude: float = ...,
        longitude: float = ...,
        altitude: float = ...,
        position_covariance: _Floats = ...,
        position_covariance_type: int = ...,
    ) -> None: ...

class NavSatStatus(_Message):
    """sensor_msgs/NavSatStatus

    # Which kind of fix a receiver has, and by which systems.

    int8 STATUS_NO_FIX=-1     # no position
    int8 STATUS_FIX=0         # without augmentation
    int8 STATUS_SBAS_FIX=1    # with satellite augmentation
    int8 STATUS_GBAS_FIX=2    # with ground augmentation
    uint16 SERVICE_GPS=1
    uint16 SERVICE_GLONASS=2
    uint16 SERVICE_COMPASS=4
    uint16 SERVICE_GALILEO=8

    int8 status               # one of STATUS_*
    uint16 service            # bits of SERVICE_*
    """

    STATUS_NO_FIX: _ClassVar[int] = -1
    STATUS_FIX: _ClassVar[int] = 0
    STATUS_SBAS_FIX: _ClassVar[int] = 1
    STATUS_GBAS_FIX: _ClassVar[int] = 2
    SERVICE_GPS: _ClassVar[int] = 1
    SERVICE_GLONASS: _ClassVar[int] = 2
    SERVICE_COMPASS: _ClassVar[int] = 4
    SERVICE_GALILEO: _ClassVar[int] = 8
    status: int
    service: int
    def __init__(
        self,
        status: int = ...,
        service: int = ...,
    ) -> None: ...

class PointCloud(_Message):
    """sensor_msgs/PointCloud

    # Points with extra channels. Superseded by PointCloud2.

    Header header
    geometry_msgs/Point32[] points  # m
    ChannelFloat32[] channels       # each holds one value per point
    """

    header: _std_msgs.Header
    points: list[_geometry_msgs.Point32]
    channels: list[ChannelFloat32]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        points: _Sequence[_geometry_msgs.Point32] = ...,
        channels: _Sequence[ChannelFloat32] = ...,
    ) -> None: ...

class PointCloud2(_Message):
    """sensor_msgs/PointCloud2

    # Points with any fields, packed: point (row, column) begins at data[row * row_step + column *
    # point_step].

    Header header
    uint32 height        # rows; 1 for a cloud without order
    uint32 width         # points per row
    PointField[] fields  # what one point holds, and where in it
    bool is_bigendian    # of the data
    uint32 point_step    # bytes per point
    uint32 row_step      # bytes per row
    uint8[] data         # row_step * height bytes
    bool is_dense        # true when no point is invalid (NaN)
    """

    header: _std_msgs.Header
    height: int
    width: int
    fields: list[PointField]
    is_bigendian: bool
    point_step: int
    row_step: int
    data: _UInt8Array
    is_dense: bool
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        height: int = ...,
        width: int = ...,
        fields: _Sequence[PointField] = ...,
        is_bigendian: bool = ...,
        point_step: int = ...,
        row_step: int = ...,
        data: _Octets = ...,
        is_dense: bool = ...,
    ) -> None: ...

class PointField(_Message):
    """sensor_msgs/PointField

    # One field of a point in a PointCloud2.

    uint8 INT8=1
    uint8 UINT8=2
    uint8 INT16=3
    uint8 UINT16=4
    uint8 INT32=5
    uint8 UINT32=6
    uint8 FLOAT32=7
    uint8 FLOAT64=8

    string name      # x, y, z, intensity, rgb ...
    uint32 offset    # bytes from the start of the point
    uint8 datatype   # one of the constants
    uint32 count     # elements of it in one point, usually 1
    """

    INT8: _ClassVar[int] = 1
    UINT8: _ClassVar[int] = 2
    INT16: _ClassVar[int] = 3
    UINT16: _ClassVar[int] = 4
    INT32: _ClassVar[int] = 5
    UINT32: _ClassVar[int] = 6
    FLOAT32: _ClassVar[int] = 7
    FLOAT64: _ClassVar[int] = 8
    name: str
    offset: int
    datatype: int
    count: int
    def __init__(
        self,
        name: str = ...,
        offset: int = ...,
        datatype: int = ...,
        count: int = ...,
    ) -> None: ...

class Range(_Message):
    """sensor_msgs/Range

    # One reading of a range sensor with a cone for a beam. A sensor that only detects sends -Inf for
    # near, +Inf for far.

    uint8 ULTRASOUND=0
    uint8 INFRARED=1

    Header header
    uint8 radiation_type   # ULTRASOUND or INFRARED
    float32 field_of_view  # opening of the cone, rad
    float32 min_range      # m
    float32 max_range      # m
    float32 range          # m along the x axis; outside min_range to max_range is not valid
    """

    ULTRASOUND: _ClassVar[int] = 0
    INFRARED: _ClassVar[int] = 1
    header: _std_msgs.Header
    radiation_type: int
    field_of_view: float
    min_range: float
    max_range: float
    range: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        radiation_type: int = ...,
        field_of_view: float = ...,
        min_range: float = ...,
        max_range: float = ...,
        range: float = ...,
    ) -> None: ...

class RegionOfInterest(_Message):
    """sensor_msgs/RegionOfInterest

    # A rectangle in an image, pixels.

    uint32 x_offset  # columns left of it
    uint32 y_offset  # rows above it
    uint32 height    # 0 means the whole image
    uint32 width     # 0 means the whole image
    bool do_rectify  # whether a rectified view of it is wanted
    """

    x_offset: int
    y_offset: int
    height: int
    width: int
    do_rectify: bool
    def __init__(
        self,
        x_offset: int = ...,
        y_offset: int = ...,
        height: int = ...,
        width: int = ...,
        do_rectify: bool = ...,
    ) -> None: ...

class RelativeHumidity(_Message):
    """sensor_msgs/RelativeHumidity

    # Relative humidity.

    Header header
    float64 relative_humidity  # 0 to 1
    float64 variance           # 0 means unknown
    """

    header: _std_msgs.Header
    relative_humidity: float
    variance: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        relative_humidity: float = ...,
        variance: float = ...,
    ) -> None: ...

class Temperature(_Message):
    """sensor_msgs/Temperature

    # One temperature.

    Header header
    float64 temperature  # degrees Celsius
    float64 variance     # 0 means unknown
    """

    header: _std_msgs.Header
    temperature: float
    variance: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        temperature: float = ...,
        variance: float = ...,
    ) -> None: ...

class TimeReference(_Message):
    """sensor_msgs/TimeReference

    # What another clock said at the time of the header.

    Header header
    time time_ref  # its time
    string source  # which clock
    """

    header: _std_msgs.Header
    time_ref: _Time
    source: str
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        time_ref: _Time = ...,
        source: str = ...,
    ) -> None: ...
