"""Makes `import rospy` and `from woosh_msgs.msg import Battery` work: finders at the front of sys.meta_path.

Two kinds of names are served:

* packages in `modules/` (rospy, actionlib, tf ...), loaded from there under their ROS name;
* message packages that `library()` has definitions of: `<package>`, `<package>.msg`,
  `<package>.srv` and `<package>.msg._Type`, modules without files (see `messages`).

Python's own import loads the user's message packages with generated code (a catkin workspace, a folder beside
the program), which then use our genpy. Message packages of a ROS installation, detected by the rospy beside
them, are served from our definitions.
"""

from __future__ import annotations

import importlib.machinery
import os
import pkgutil
import sys
from collections.abc import Sequence
from functools import cache
from types import ModuleType

from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, bundled

MSG_PATH = "ROSPROTO_MSG_PATH"
"""Environment: folders with definitions, joined as PATH is; children of a program find them there."""
# No base class from importlib.abc: importing that takes 20 ms, and Python asks only for the methods.
ENVIRONMENT = {"ROS_VERSION": "1", "ROS_DISTRO": "noetic", "ROS_PYTHON_VERSION": "3"}
"""What the set-up script of a ROS installation sets, and programs read; set where it is not."""
KINDS = ("msg", "srv")
MODULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "modules")
"""The stand-ins for ROS's modules: a folder, also inside a zip."""
SUBMODULES = "_submodules"
"""In `modules/`: other modules of message packages."""
NOT_OVER_THIS = frozenset({"roslaunch", "rosmaster"})
"""Modules of a ROS installation that use parts of ROS modules that ours do not have."""
SPARE = frozenset({"PyKDL", "rospkg"})
"""Served only when they are not installed: the real ones have more functions and need no ROS."""


@cache
def library() -> DefinitionLibrary:
    """The definitions of this process: the folders of `--msg-path`, then the bundled ones.

    The environment is read on the first call.
    """
    folders = [folder for folder in os.environ.get(MSG_PATH, "").split(os.pathsep) if folder]
    try:
        return bundled().fork(folders) if folders else bundled()
    except DefinitionError as error:
        raise DefinitionError(f"{error}; it was given by --msg-path or by the variable {MSG_PATH}") from None


def serve() -> None:
    """Put the finders in place, and set ROS's variables; a second call does nothing.

    Raises:
        DefinitionError: A folder of definitions cannot be used.
    """
    if not any(isinstance(finder, RosFinder) for finder in sys.meta_path):
        for name, value in {**ENVIRONMENT, "ROS_ROOT": MODULES}.items():
            os.environ.setdefault(name, value)
        sys.meta_path.insert(0, RosFinder())
        sys.meta_path.append(FallbackFinder())
        _serve_children()


def stand_ins() -> frozenset[str]:
    """Names of the modules and packages of ROS that are provided, without the message packages."""
    return frozenset(module.name for module in pkgutil.iter_modules([MODULES]))


class RosFinder:
    """Finds the modules that this layer provides; leaves everything else to the finders behind it."""

    def __init__(self) -> None:
        self._modules = stand_ins() - SPARE
        # Read once: every import of the process calls find_spec, the library's own imports too.
        self._packages = frozenset(library().packages())

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """The spec of a module that this layer provides, None for any other.

        Raises:
            ModuleNotFoundError: An import asks for a part of a ROS installation that does not work with this
                layer; it says what to use instead.
        """
        package, _, rest = fullname.partition(".")
        if not rest:
            if package in self._modules:
                return _spec_of_module(package)
            if package in NOT_OVER_THIS and _came_with_ros(package) and _is_imported():
                raise ModuleNotFoundError(_absence(package), name=package)
            return self._message_spec(fullname) if self._is_ours(package) else None
        kind, _, base = rest.partition(".")
        of_rospy = package in self._modules
        if (
            kind in KINDS
            and "." not in base
            and (package in self._packages if of_rospy else self._is_ours(package))
        ):
            return self._message_spec(fullname) if _has_definitions(package, kind) else None
        return _spec_of_module(fullname, *([] if of_rospy else [SUBMODULES]))

    @staticmethod
    def _message_spec(name: str) -> importlib.machinery.ModuleSpec:
        from rosproto.rospy.messages import MessageModuleLoader

        return importlib.machinery.ModuleSpec(
            name,
            MessageModuleLoader(),  # type: ignore[arg-type]
            origin="rosproto",
            is_package=name.count(".") < 2,
        )

    def _is_ours(self, package: str) -> bool:
        return package in self._packages and not _has_generated_code(package)


class FallbackFinder:
    """The last finder: provides modules that are not installed, or explains why it cannot."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return the spec of a fallback module, None for any other.

        Raises:
            ModuleNotFoundError: The module cannot be served; the message names the replacement.
        """
        spec = _spec_of_module(fullname) if fullname.partition(".")[0] in SPARE else None
        if spec is not None:
            return spec
        text = _absence(fullname)
        if text is not None and _is_imported():
            raise ModuleNotFoundError(text, name=fullname)
        return None


def _spec_of_module(name: str, *folders: str) -> importlib.machinery.ModuleSpec | None:
    """The spec of a module in `modules/`, None when there is none of that name."""
    place = os.path.join(MODULES, *folders, *name.split(".")[:-1])
    spec = importlib.machinery.PathFinder.find_spec(name, [place])
    return spec if spec is not None and spec.has_location else None  # without __init__.py it is not a package


def _has_definitions(package: str, kind: str) -> bool:
    """True when genpy would have written `<package>.msg`, or `.srv`."""
    known = library()
    return bool(known.messages(package) if kind == "msg" else known.services(package))


@cache
def _has_generated_code(package: str) -> bool:
    """True when the user has generated code of that package on sys.path."""
    entry = _entry_with(*(os.path.join(package, kind) for kind in KINDS))
    return entry is not None and not _is_of_ros(entry)


def _came_with_ros(package: str) -> bool:
    """True when the package on sys.path is one of a ROS installation, not the user's own."""
    entry = _entry_with(package)
    return entry is not None and _is_of_ros(entry)


def _entry_with(*packages: str) -> str | None:
    """The first folder of sys.path that has one of these packages."""
    for entry in sys.path:
        folder = entry or os.curdir
        if any(os.path.isfile(os.path.join(folder, package, "__init__.py")) for package in packages):
            return folder
    return None


def _is_of_ros(folder: str) -> bool:
    return os.path.isfile(os.path.join(folder, "rospy", "__init__.py"))


def _serve_children() -> None:
    """Processes that multiprocessing starts anew import this first (Windows, macOS, Linux from 3.14 on)."""
    from multiprocessing import set_forkserver_preload, spawn

    command_line = spawn.get_command_line

    def with_layer(**kwargs: object) -> list[str]:
        line = command_line(**kwargs)
        if "-c" in line:
            at = line.index("-c") + 1
            line[at] = "import rosproto.rospy.install; " + line[at]
        return line

    spawn.get_command_line = with_layer
    if sys.platform != "win32":
        # Without Python's own "__main__": the server would import the program before this layer.
        set_forkserver_preload(["rosproto.rospy.install"])


# -- modules of ROS that cannot be provided: why, and what to use instead ------------------------------------

_BRING = "it is pure Python; put its folder %s on PYTHONPATH"
_CPP = "it is a front end to C++ code of a ROS installation; "
_GUI = "it is one of ROS's windows; use matplotlib or a web page, or run that part on a computer with ROS"
_REMOTE = _CPP + "run that part on a computer with ROS and talk to it by topics, services and actions"

_BUILD = "nothing is built here: run the program's file itself"
_NO_CODE = "no code is generated: classes are made from definitions when imported (--msg-path FOLDER)"

_ABSENT = {
    "camera_info_manager": _BRING % "src/camera_info_manager (of camera_info_manager_py)",
    "catkin": _BUILD,
    "gencpp": _NO_CODE,
    "genlisp": _NO_CODE,
    "interactive_markers": _BRING % "src/interactive_markers",
    "moveit_commander": _REMOTE,
    "nodelet": "nodelets are C++; run the node's stand-alone executable on a computer with ROS",
    "pcl": _CPP + "sensor_msgs.point_cloud2 gives the points; numpy or open3d work on them",
    "python_qt_binding": _GUI,
    "qt_gui": _GUI,
    "rclpy": "that is ROS 2; this layer speaks ROS 1 (import rospy)",
    "resource_retriever": "read the file by open(); rospkg.RosPack().get_path() gives a package's folder",
    "rosclean": "log files are in ~/.ros/log; delete what you do not need",
    "roscreate": _BUILD,
    "roslz4": "lz4.frame reads and writes the same format",
    "roswtf": "the command `rosproto doctor` examines a graph",
    "ros_numpy": _BRING % "src/ros_numpy",
    "roslaunch": (
        "launch files and the processes they start are not served: start the programs one by one "
        "(rosproto run FILE), or from Python by subprocess; `rosproto param load` loads YAML files"
    ),
    "rosmaster": "the master is rosproto's: rosproto.Master(), or the command `rosproto master`",
    "rosout": "rosproto.Node and `rosproto log echo` read /rosout",
    "rqt_gui": _GUI,
    "rqt_gui_py": _GUI,
    "rviz": _GUI,
    "smach": _BRING % "src/smach (of executive_smach)",
    "smach_ros": _BRING % "src/smach_ros (of executive_smach)",
    "tf2_kdl": "tf2_geometry_msgs moves messages between frames, tf_conversions.posemath makes PyKDL frames",
    "urdf_parser_py": "it is pure Python: pip install urdf-parser-py",
}
_ABSENT_PARTS = {
    "genmsg": _NO_CODE,
    "genpy": _NO_CODE,
    "rosbag": "rosbag.Bag, or the command `rosproto bag`, does what bags need",
    "rosgraph": "rosgraph.Master calls the master; rosproto.Node has a server for its slave API",
    "roslib": "it is of the build before catkin; roslib.packages finds packages, genmsg reads definitions",
    "rospkg": "the real one has it: pip install rospkg",
    "rospy": "this layer has no such part of rospy, whose connections and commands are rosproto's here",
    "rostest": "launch files are not served: rostest.rosrun runs a test, and unittest or pytest find tests",
    "rosunit": "rosunit.unitrun runs a test, and unittest or pytest find tests",
    "tf": "tf.TransformListener, tf.TransformBroadcaster and tf.transformations are what there is",
}
"""Parts of served packages that hardly any program uses: what there is in their place."""
_DEFINITIONS = (
    "it is not a package of this computer, and its definitions are not bundled. Give the folder that holds "
    "%s/msg/*.msg (rosproto run --msg-path FOLDER, or ROSPROTO_MSG_PATH), or put its generated code on "
    "PYTHONPATH"
)
_WITH_DEFINITIONS = frozenset({"beginner_tutorials", "roscpp_tutorials", "rospy_tutorials", "turtlesim"})


def _absence(name: str) -> str | None:
    """Return the error text for a ROS module that was not found; None for other modules."""
    package, _, part = name.partition(".")
    why = _ABSENT_PARTS.get(package) if part else _ABSENT.get(name)
    if why is None and (name.endswith(("_msgs", "_srvs", "_interfaces")) or name in _WITH_DEFINITIONS):
        why = _DEFINITIONS % name
    return None if why is None else f"No module named {name!r}: {why}"


def _is_imported() -> bool:
    """True when the calling finder was called by an import, not by importlib.util.find_spec."""
    frame = sys._getframe(2).f_back  # the finder's caller: importlib's _find_spec
    return frame is not None and frame.f_code.co_name == "_find_and_load_unlocked"
