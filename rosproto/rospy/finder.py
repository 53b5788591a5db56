"""Makes `import rospy` and `from woosh_msgs.msg import Battery` work: finders at the front of sys.meta_path.

Two kinds of names are served:

* packages in `modules/` (rospy, actionlib, tf ...), loaded from there under their ROS name;
* message packages that `definitions.library()` has definitions of: `<package>`, `<package>.msg`,
  `<package>.srv` and `<package>.msg._Type`, modules without files (see `message_modules`).

Python's own import loads the user's message packages with generated code (a catkin workspace, a folder beside
the program), which then use our genpy. Message packages of a ROS installation, detected by the rospy beside
them, are served from our definitions.
"""

from __future__ import annotations

import importlib.machinery
import os
import sys
from collections.abc import Sequence
from types import ModuleType

from rosproto.rospy.absent import NOT_OVER_THIS, absence, is_imported
from rosproto.rospy.definitions import library

# No base class from importlib.abc: importing that takes 20 ms, and Python asks only for the methods.
KINDS = ("msg", "srv")
MODULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "modules")
"""The stand-ins for ROS's modules: a folder, also inside a zip."""
SUBMODULES = "_submodules"
"""In `modules/`: other modules of message packages."""
SPARE = frozenset({"PyKDL", "rospkg"})
"""Served only when they are not installed: the real ones have more functions and need no ROS."""


def serve() -> None:
    """Put the finder at the front; a second call does nothing."""
    if not any(isinstance(finder, RosFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, RosFinder())
        sys.meta_path.append(FallbackFinder())
        if "multiprocessing.spawn" in sys.modules:
            _serve_children(sys.modules["multiprocessing.spawn"])


def stand_ins() -> frozenset[str]:
    """Names of the modules and packages of ROS that are provided, without the message packages."""
    return _names_in(MODULES)


class RosFinder:
    """Finds the modules that this layer provides; leaves everything else to the finders behind it."""

    def __init__(self) -> None:
        self._modules = stand_ins() - SPARE
        # Read once: every import of the process calls find_spec, the library's own imports too.
        self._packages = frozenset(library().packages())
        self._ours: dict[str, bool] = {}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """The spec of a module that this layer provides, None for any other.

        Raises:
            ModuleNotFoundError: An import asks for a part of a ROS installation that does not work with this
                layer; it says what to use instead.
        """
        if fullname == "multiprocessing.spawn":
            return self._patched(fullname, path)
        package, _, rest = fullname.partition(".")
        if not rest:
            if package in self._modules:
                return _spec_of_module(package)
            if package in NOT_OVER_THIS and _came_with_ros(package) and is_imported():
                raise ModuleNotFoundError(absence(package), name=package)
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
        from rosproto.rospy.message_modules import MessageModuleLoader

        return importlib.machinery.ModuleSpec(
            name,
            MessageModuleLoader(),  # type: ignore[arg-type]
            origin="rosproto",
            is_package=name.count(".") < 2,
        )

    def _is_ours(self, package: str) -> bool:
        if package not in self._packages:
            return False
        known = self._ours.get(package)
        if known is None:
            known = self._ours[package] = not _has_generated_code(package)
        return known

    @staticmethod
    def _patched(name: str, path: Sequence[str] | None) -> importlib.machinery.ModuleSpec | None:
        """The real multiprocessing.spawn, changed so that child processes get the finder too."""
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is not None and spec.loader is not None:
            spec.loader = _PatchedLoader(spec.loader)  # type: ignore[assignment]
        return spec


class _PatchedLoader:
    """Wraps the loader of one module and adds to it. The wrapped one is unchanged: a zip has one for all."""

    def __init__(self, loader: object) -> None:
        self._loader = loader

    def __getattr__(self, name: str) -> object:
        return getattr(self._loader, name)

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)  # type: ignore[attr-defined]
        _serve_children(module)


class FallbackFinder:
    """The last finder: provides modules that are not installed, or explains why it cannot."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return the spec of a fallback module, None for any other.

        Raises:
            ModuleNotFoundError: The module cannot be served; the message names the replacement.
        """
        if fullname.partition(".")[0] in SPARE:
            return _spec_of_module(fullname)
        text = absence(fullname)
        if text is not None and is_imported():
            raise ModuleNotFoundError(text, name=fullname)
        return None


def _names_in(folder: str) -> frozenset[str]:
    """Names of all modules and packages in a folder but those with an underscore."""
    try:
        entries = os.scandir(folder)
    except (NotADirectoryError, FileNotFoundError):  # inside a zip; the second on Windows
        import pkgutil

        names = {module.name for module in pkgutil.iter_modules([folder])}
    else:
        names = {e.name.removesuffix(".py") for e in entries if e.is_dir() or e.name.endswith(".py")}
    return frozenset(name for name in names if not name.startswith(("_", ".")))


def _spec_of_module(name: str, *folders: str) -> importlib.machinery.ModuleSpec | None:
    """The spec of a module in `modules/`, None when there is none of that name."""
    place = os.path.join(MODULES, *folders, *name.split(".")[:-1])
    spec = importlib.machinery.PathFinder.find_spec(name, [place])
    return spec if spec is not None and spec.has_location else None  # without __init__.py it is no package


def _has_definitions(package: str, kind: str) -> bool:
    """True when genpy would have written `<package>.msg`, or `.srv`."""
    known = library()
    return bool(known.messages(package) if kind == "msg" else known.services(package))


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


def _serve_children(spawn: ModuleType) -> None:
    """Processes that multiprocessing starts anew (Windows, macOS) import this layer first."""
    command_line = spawn.get_command_line

    def with_layer(**kwargs: object) -> list[str]:
        line: list[str] = command_line(**kwargs)
        if "-c" in line:
            at = line.index("-c") + 1
            line[at] = "import rosproto.rospy.install; " + line[at]
        return line

    spawn.get_command_line = with_layer  # type: ignore[attr-defined]
