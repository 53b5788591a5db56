"""Convert bags to bags of ROS 2 with the package rosbags (the extra `ros2`).

Messages are serialized as CDR, and types get their ROS 2 names. Definitions stay as recorded, except
`std_msgs/Header`, which has no `seq` in ROS 2, and constants with names that ROS 2 does not allow. Types that
ROS 2 has changed, such as `visualization_msgs/Marker`, keep their ROS 1 definition.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING

from rosproto.bag.reader import BagReader
from rosproto.bag.records import NS
from rosproto.codec import Message
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.errors import BagError
from rosproto.extras import optional_module
from rosproto.sentence import say

if TYPE_CHECKING:
    from rosbags.interfaces import Connection as Ros2Connection
    from rosbags.interfaces import Qos
    from rosbags.rosbag2 import Writer

_CONSTANT = re.compile(r"[A-Z][A-Z0-9_]*")
_HEADER = "std_msgs/msg/Header"


def write_ros2(bag: BagReader, path: str | os.PathLike[str], step: Callable[[], None] | None = None) -> int:
    """Write all messages into a new bag of ROS 2 (a directory, with SQLite); returns how many.

    Args:
        bag: The source.
        path: The new directory; an existing one is not replaced. After a failure it is removed.
        step: Called after each message.

    Raises:
        BagError: It already exists or cannot be written, a message cannot be converted, or the package
            rosbags is missing (extra `ros2`).
    """
    text = os.fspath(path)
    if os.path.exists(text):
        raise BagError("it already exists; choose another name", path=text)
    store = _Store()
    rosbag2 = _library("rosbag2")
    try:
        with rosbag2.Writer(text, version=8, storage_plugin=rosbag2.StoragePlugin.SQLITE3) as writer:
            return _write(bag, writer, store, step)
    except BagError:
        shutil.rmtree(text, ignore_errors=True)
        raise
    except Exception as problem:  # rosbags raises its own errors and SQLite's
        shutil.rmtree(text, ignore_errors=True)
        raise BagError(f"it cannot be written: {problem or type(problem).__name__}", path=text) from problem
    except BaseException:
        shutil.rmtree(text, ignore_errors=True)
        raise


def _write(bag: BagReader, writer: Writer, store: _Store, step: Callable[[], None] | None) -> int:
    targets: dict[int, tuple[str, Ros2Connection]] = {}
    known: dict[tuple[str, str, bool], Ros2Connection] = {}
    for connection in bag.connections.values():
        name = store.learn(bag.message_class(connection))
        key = connection.topic, name, connection.latching
        if key not in known:
            profiles = [store.latched()] if connection.latching else []
            known[key] = writer.add_connection(
                connection.topic, name, typestore=store.types, offered_qos_profiles=profiles
            )
        targets[connection.id] = name, known[key]
    count = 0
    for topic, raw, stamp in bag.read_messages(raw=True):
        name, target = targets[raw.connection.id]
        try:
            data = store.types.ros1_to_cdr(raw.data, name)
        except Exception as problem:  # any error of the generated code
            raise BagError(
                f"{topic}: a message of {raw.type} does not match its definition: "
                f"{problem or type(problem).__name__}",
                path=bag.path,
                offset=raw.position[0],
            ) from problem
        writer.write(target, stamp.secs * NS + stamp.nsecs, data)
        count += 1
        if step is not None:
            step()
    return count


class _Store:
    """Types in rosbags' form.

    Attributes:
        types: The typestore of rosbags.
    """

    def __init__(self) -> None:
        typesys = _library("typesys")
        self._parse = typesys.get_types_from_msg
        self._known: dict[str, str] = {}
        modern = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE).fielddefs
        self.types = typesys.get_typestore(typesys.Stores.EMPTY)
        self.types.register(
            {
                name: modern[name]
                for name in ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration", _HEADER)
            }
        )

    def learn(self, cls: type[Message]) -> str:
        """Register a class and its nested types; returns its name in ROS 2.

        Raises:
            BagError: rosbags refuses its definition, or has another one of that name.
        """
        assert cls._binding is not None
        return self._add(cls._binding.layout)

    def _add(self, layout: Layout) -> str:
        name = layout.spec.name.replace("/", "/msg/")
        if name == _HEADER:
            return name
        for field in layout.fields:
            if field.layout is not None:
                self._add(field.layout)
        text = "".join([_line(field) for field in layout.fields] + _constants(layout))
        if name in self._known:
            if self._known[name] != text:
                wrong = "the bag has two definitions of {type}; a bag of ROS 2 has only one"
                raise BagError(say(wrong, type=layout.spec.name))
            return name
        self._known[name] = text
        try:
            found = self._parse(text, name)
            self.types.register({name: found[name]})
        except Exception as problem:  # any error of its parser
            raise BagError(
                f"rosbags does not accept the definition of {layout.spec.name}: {problem}"
            ) from problem
        return name

    def latched(self) -> Qos:
        """The ROS 2 quality of service of a latched topic."""
        qos = _library("interfaces")  # the package's own converter writes the same
        latched: Qos = qos.Qos(
            history=qos.QosHistory.KEEP_LAST,
            depth=1,
            reliability=qos.QosReliability.RELIABLE,
            durability=qos.QosDurability.TRANSIENT_LOCAL,
            deadline=qos.QosTime(0, 0),
            lifespan=qos.QosTime(0, 0),
            liveliness=qos.QosLiveliness.SYSTEM_DEFAULT,
            liveliness_lease_duration=qos.QosTime(0, 0),
            avoid_ros_namespace_conventions=False,
        )
        return latched


def _line(field: FieldLayout) -> str:
    kind = field.base if field.layout is None else field.layout.spec.name
    many = f"[{field.length or ''}]" if field.is_array else ""
    return f"{kind}{many} {field.name}\n"


def _constants(layout: Layout) -> list[str]:
    """Numeric constants with names that ROS 2 allows."""
    return [
        f"{constant.type} {constant.name}={constant.value!r}\n"
        for constant in layout.spec.constants
        if _CONSTANT.fullmatch(constant.name) and type(constant.value) in (int, float)
    ]


def _library(module: str) -> ModuleType:
    missing = BagError('bags for ROS 2 need the package rosbags: pip install ".[ros2]"')
    return optional_module(f"rosbags.{module}", missing)
