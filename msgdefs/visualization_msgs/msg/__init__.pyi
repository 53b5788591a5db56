# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of visualization_msgs as classes."""

from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar

import msgdefs.geometry_msgs.msg as _geometry_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message
from rosproto.time import Duration as _Duration

class ImageMarker(_Message):
    """visualization_msgs/ImageMarker

    uint8 CIRCLE=0
    uint8 LINE_STRIP=1
    uint8 LINE_LIST=2
    uint8 POLYGON=3
    uint8 POINTS=4
    uint8 ADD=0
    uint8 REMOVE=1

    Header header
    string ns
    int32 id
    int32 type
    int32 action
    geometry_msgs/Point position
    float32 scale
    std_msgs/ColorRGBA outline_color
    uint8 filled
    std_msgs/ColorRGBA fill_color
    duration lifetime
    geometry_msgs/Point[] points
    std_msgs/ColorRGBA[] outline_colors
    """

    CIRCLE: _ClassVar[int] = 0
    LINE_STRIP: _ClassVar[int] = 1
    LINE_LIST: _ClassVar[int] = 2
    POLYGON: _ClassVar[int] = 3
    POINTS: _ClassVar[int] = 4
    ADD: _ClassVar[int] = 0
    REMOVE: _ClassVar[int] = 1
    header: _std_msgs.Header
    ns: str
    id: int
    type: int
    action: int
    position: _geometry_msgs.Point
    scale: float
    outline_color: _std_msgs.ColorRGBA
    filled: int
    fill_color: _std_msgs.ColorRGBA
    lifetime: _Duration
    points: list[_geometry_msgs.Point]
    outline_colors: list[_std_msgs.ColorRGBA]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        ns: str = ...,
        id: int = ...,
        type: int = ...,
        action: int = ...,
        position: _geometry_msgs.Point = ...,
        scale: float = ...,
        outline_color: _std_msgs.ColorRGBA = ...,
        filled: int = ...,
        fill_color: _std_msgs.ColorRGBA = ...,
        lifetime: _Duration = ...,
        points: _Sequence[_geometry_msgs.Point] = ...,
        outline_colors: _Sequence[_std_msgs.ColorRGBA] = ...,
    ) -> None: ...

class InteractiveMarker(_Message):
    """visualization_msgs/InteractiveMarker

    Header header
    geometry_msgs/Pose pose
    string name
    string description
    float32 scale
    MenuEntry[] menu_entries
    InteractiveMarkerControl[] controls
    """

    header: _std_msgs.Header
    pose: _geometry_msgs.Pose
    name: str
    description: str
    scale: float
    menu_entries: list[MenuEntry]
    controls: list[InteractiveMarkerControl]
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        pose: _geometry_msgs.Pose = ...,
        name: str = ...,
        description: str = ...,
        scale: float = ...,
        menu_entries: _Sequence[MenuEntry] = ...,
        controls: _Sequence[InteractiveMarkerControl] = ...,
    ) -> None: ...

class InteractiveMarkerControl(_Message):
    """visualization_msgs/InteractiveMarkerControl

    uint8 INHERIT=0
    uint8 FIXED=1
    uint8 VIEW_FACING=2
    uint8 NONE=0
    uint8 MENU=1
    uint8 BUTTON=2
    uint8 MOVE_AXIS=3
    uint8 MOVE_PLANE=4
    uint8 ROTATE_AXIS=5
    uint8 MOVE_ROTATE=6
    uint8 MOVE_3D=7
    uint8 ROTATE_3D=8
    uint8 MOVE_ROTATE_3D=9

    string name
    geometry_msgs/Quaternion orientation
    uint8 orientation_mode
    uint8 interaction_mode
    bool always_visible
    Marker[] markers
    bool independent_marker_orientation
    string description
    """

    INHERIT: _ClassVar[int] = 0
    FIXED: _ClassVar[int] = 1
    VIEW_FACING: _ClassVar[int] = 2
    NONE: _ClassVar[int] = 0
    MENU: _ClassVar[int] = 1
    BUTTON: _ClassVar[int] = 2
    MOVE_AXIS: _ClassVar[int] = 3
    MOVE_PLANE: _ClassVar[int] = 4
    ROTATE_AXIS: _ClassVar[int] = 5
    MOVE_ROTATE: _ClassVar[int] = 6
    MOVE_3D: _ClassVar[int] = 7
    ROTATE_3D: _ClassVar[int] = 8
    MOVE_ROTATE_3D: _ClassVar[int] = 9
    name: str
    orientation: _geometry_msgs.Quaternion
    orientation_mode: int
    interaction_mode: int
    always_visible: bool
    markers: list[Marker]
    independent_marker_orientation: bool
    description: str
    def __init__(
        self,
        name: str = ...,
        orientation: _geometry_msgs.Quaternion = ...,
        orientation_mode: int = ...,
        interaction_mode: int = ...,
        always_visible: bool = ...,
        markers: _Sequence[Marker] = ...,
        independent_marker_orientation: bool = ...,
        description: str = ...,
    ) -> None: ...

class InteractiveMarkerFeedback(_Message):
    """visualization_msgs/InteractiveMarkerFeedback

    uint8 KEEP_ALIVE=0
    uint8 POSE_UPDATE=1
    uint8 MENU_SELECT=2
    uint8 BUTTON_CLICK=3
    uint8 MOUSE_DOWN=4
    uint8 MOUSE_UP=5

    Header header
    string client_id
    string marker_name
    string control_name
    uint8 event_type
    geometry_msgs/Pose pose
    uint32 menu_entry_id
    geometry_msgs/Point mouse_point
    bool mouse_point_valid
    """

    KEEP_ALIVE: _ClassVar[int] = 0
    POSE_UPDATE: _ClassVar[int] = 1
    MENU_SELECT: _ClassVar[int] = 2
    BUTTON_CLICK: _ClassVar[int] = 3
    MOUSE_DOWN: _ClassVar[int] = 4
    MOUSE_UP: _ClassVar[int] = 5
    header: _std_msgs.Header
    client_id: str
    marker_name: str
    control_name: str
    event_type: int
    pose: _geometry_msgs.Pose
    menu_entry_id: int
    mouse_point: _geometry_msgs.Point
    mouse_point_valid: bool
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        client_id: str = ...,
        marker_name: str = ...,
        control_name: str = ...,
        event_type: int = ...,
        pose: _geometry_msgs.Pose = ...,
        menu_entry_id: int = ...,
        mouse_point: _geometry_msgs.Point = ...,
        mouse_point_valid: bool = ...,
    ) -> None: ...

class InteractiveMarkerInit(_Message):
    """visualization_msgs/InteractiveMarkerInit

    string server_id
    uint64 seq_num
    InteractiveMarker[] markers
    """

    server_id: str
    seq_num: int
    markers: list[InteractiveMarker]
    def __init__(
        self,
        server_id: str = ...,
        seq_num: int = ...,
        markers: _Sequence[InteractiveMarker] = ...,
    ) -> None: ...

class InteractiveMarkerPose(_Message):
    """visualization_msgs/InteractiveMarkerPose

    Header header
    geometry_msgs/Pose pose
    string name
    """

    header: _std_msgs.Header
    pose: _geometry_msgs.Pose
    name: str
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        pose: _geometry_msgs.Pose = ...,
        name: str = ...,
    ) -> None: ...

class InteractiveMarkerUpdate(_Message):
    """visualization_msgs/InteractiveMarkerUpdate

    uint8 KEEP_ALIVE=0
    uint8 UPDATE=1

    string server_id
    uint64 seq_num
    uint8 type
    InteractiveMarker[] markers
    InteractiveMarkerPose[] poses
    string[] erases
    """

    KEEP_ALIVE: _ClassVar[int] = 0
    UPDATE: _ClassVar[int] = 1
    server_id: str
    seq_num: int
    type: int
    markers: list[InteractiveMarker]
    poses: list[InteractiveMarkerPose]
    erases: list[str]
    def __init__(
        self,
        server_id: str = ...,
        seq_num: int = ...,
        type: int = ...,
        markers: _Sequence[InteractiveMarker] = ...,
        poses: _Sequence[InteractiveMarkerPose] = ...,
        erases: _Sequence[str] = ...,
    ) -> None: ...

class Marker(_Message):
    """visualization_msgs/Marker

    # Something to draw. (ns, id) names it: a second one of that name replaces it.

    uint8 ARROW=0
    uint8 CUBE=1
    uint8 SPHERE=2
    uint8 CYLINDER=3
    uint8 LINE_STRIP=4
    uint8 LINE_LIST=5
    uint8 CUBE_LIST=6
    uint8 SPHERE_LIST=7
    uint8 POINTS=8
    uint8 TEXT_VIEW_FACING=9
    uint8 MESH_RESOURCE=10
    uint8 TRIANGLE_LIST=11
    uint8 ADD=0
    uint8 MODIFY=0
    uint8 DELETE=2
    uint8 DELETEALL=3

    Header header
    string ns                         # namespace of the id
    int32 id
    int32 type                        # ARROW to TRIANGLE_LIST
    int32 action                      # ADD, DELETE or DELETEALL
    geometry_msgs/Pose pose
    geometry_msgs/Vector3 scale       # m
    std_msgs/ColorRGBA color
    duration lifetime                 # 0 means for ever
    bool frame_locked                 # follow the frame when it moves
    geometry_msgs/Point[] points      # for lines, lists and arrows, m
    std_msgs/ColorRGBA[] colors       # one per point, or empty
    string text                       # for TEXT_VIEW_FACING
    string mesh_resource              # for MESH_RESOURCE, a package:// or file:// URL
    bool mesh_use_embedded_materials
    """

    ARROW: _ClassVar[int] = 0
    CUBE: _ClassVar[int] = 1
    SPHERE: _ClassVar[int] = 2
    CYLINDER: _ClassVar[int] = 3
    LINE_STRIP: _ClassVar[int] = 4
    LINE_LIST: _ClassVar[int] = 5
    CUBE_LIST: _ClassVar[int] = 6
    SPHERE_LIST: _ClassVar[int] = 7
    POINTS: _ClassVar[int] = 8
    TEXT_VIEW_FACING: _ClassVar[int] = 9
    MESH_RESOURCE: _ClassVar[int] = 10
    TRIANGLE_LIST: _ClassVar[int] = 11
    ADD: _ClassVar[int] = 0
    MODIFY: _ClassVar[int] = 0
    DELETE: _ClassVar[int] = 2
    DELETEALL: _ClassVar[int] = 3
    header: _std_msgs.Header
    ns: str
    id: int
    type: int
    action: int
    pose: _geometry_msgs.Pose
    scale: _geometry_msgs.Vector3
    color: _std_msgs.ColorRGBA
    lifetime: _Duration
    frame_locked: bool
    points: list[_geometry_msgs.Point]
    colors: list[_std_msgs.ColorRGBA]
    text: str
    mesh_resource: str
    mesh_use_embedded_materials: bool
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        ns: str = ...,
        id: int = ...,
        type: int = ...,
        action: int = ...,
        pose: _geometry_msgs.Pose = ...,
        scale: _geometry_msgs.Vector3 = ...,
        color: _std_msgs.ColorRGBA = ...,
        lifetime: _Duration = ...,
        frame_locked: bool = ...,
        points: _Sequence[_geometry_msgs.Point] = ...,
        colors: _Sequence[_std_msgs.ColorRGBA] = ...,
        text: str = ...,
        mesh_resource: str = ...,
        mesh_use_embedded_materials: bool = ...,
    ) -> None: ...

class MarkerArray(_Message):
    """visualization_msgs/MarkerArray

    Marker[] markers
    """

    markers: list[Marker]
    def __init__(
        self,
        markers: _Sequence[Marker] = ...,
    ) -> None: ...

class MenuEntry(_Message):
    """visualization_msgs/MenuEntry

    uint8 FEEDBACK=0
    uint8 ROSRUN=1
    uint8 ROSLAUNCH=2

    uint32 id
    uint32 parent_id
    string title
    string command
    uint8 command_type
    """

    FEEDBACK: _ClassVar[int] = 0
    ROSRUN: _ClassVar[int] = 1
    ROSLAUNCH: _ClassVar[int] = 2
    id: int
    parent_id: int
    title: str
    command: str
    command_type: int
    def __init__(
        self,
        id: int = ...,
        parent_id: int = ...,
        title: str = ...,
        command: str = ...,
        command_type: int = ...,
    ) -> None: ...
