"""Encoding and decoding beside genpy and rosbags, on one interpreter, interleaved, collector on.

    PYTHONPATH=.:<site-packages with numpy and rosbags> /usr/bin/python3 -m tests.benchmarks codec

Each cell is the median of five rounds; in a round genpy, ours and rosbags take turns. "use" reads every field
once after decoding. Options: --all adds every message of msgdefs, --only TEXT selects rows, --rounds N.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import gc
import importlib
import io
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import timeit
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rosproto.codec import decode, decoder, encode, encoder, message_class
from rosproto.msg import bundled


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks codec")
    parser.add_argument("--all", action="store_true", help="also every message of msgdefs, against rosbags")
    parser.add_argument("--only", default="", help="rows that contain this text")
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args(arguments)
    with genpy_classes() as genpy_class:
        rosbags = Rosbags.create()
        print(
            f"python {sys.version.split()[0]}, genpy {'there' if genpy_class else 'absent'}, "
            f"rosbags {'there' if rosbags else 'absent'}; collector on; medians of {args.rounds}"
        )
        if genpy_class is None:
            print(where_genpy_is())
        print(
            "ratios: genpy / ours (encode by encoder(cls), decode by decoder(cls)); "
            "'face' the same through encode() and decode()"
        )
        print(
            f"{'message':28} {'enc us':>8} {'dec us':>8} | {'enc x':>6} {'dec x':>6} {'face e':>6} {'face d':>6}"
            f" {'use x':>6} {'use slow':>8} | {'rosbags e':>9} {'d x':>6} | {'memcpy e':>8}"
        )
        for label, type_name, data in rows():
            if args.only.lower() in label.lower():
                print(line(label, type_name, data, genpy_class, rosbags, args.rounds))
        if args.all and rosbags:
            every_message(rosbags, args.rounds)


@contextlib.contextmanager
def genpy_classes() -> Iterator[Callable[[str], Any] | None]:
    """genpy's classes, generated from our definitions into a folder that goes away."""
    try:
        import genpy  # noqa: F401
    except ImportError:
        yield None
        return
    from tests.interop.genpy_build import generate, write_definitions

    with tempfile.TemporaryDirectory() as folder:
        write_definitions(Path(folder, "definitions"))
        generate(Path(folder, "definitions"), Path(folder, "generated"))
        sys.path.insert(0, str(Path(folder, "generated")))
        importlib.invalidate_caches()

        def find(name: str) -> Any:
            package, _, base = name.partition("/")
            return getattr(importlib.import_module(f"{package}.msg"), base)

        try:
            yield find
        finally:
            sys.path.pop(0)


def where_genpy_is() -> str:
    """What to type for the columns that need genpy."""
    packages = Path(importlib.import_module("numpy").__file__ or "").parent.parent
    for python in ("/usr/bin/python3", shutil.which("python3")):
        if python and subprocess.run([python, "-c", "import genpy"], capture_output=True).returncode == 0:
            return (
                "genpy is not installed for this interpreter, its columns stay empty; fill them with\n"
                f"    PYTHONPATH=.:{packages} {python} -m tests.benchmarks codec\n"
                "(the same minor version of Python, if numpy comes from here)"
            )
    return "genpy is not installed here (Debian: apt install python3-genpy): its columns stay empty"


class Rosbags:
    """rosbags' codec, as a peer."""

    def __init__(self, store: Any) -> None:
        self.store = store

    @classmethod
    def create(cls) -> Rosbags | None:
        try:
            from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        except ImportError:
            return None
        store = get_typestore(Stores.ROS1_NOETIC)
        library = bundled()
        types: dict[str, Any] = {}
        for package in library.packages():
            for name in library.messages(package):
                # Without constants: rosbags refuses lower-case names of them, as Battery.msg has.
                fields = library.message(name).fields
                text = "\n".join(f"{field.type} {field.name}" for field in fields) + "\n"
                types.update(get_types_from_msg(text, name.replace("/", "/msg/")))
        known = {name: value for name, value in types.items() if name not in store.fielddefs}
        store.register(known)
        return cls(store)

    def decode(self, name: str) -> Callable[[bytes], Any]:
        full = name.replace("/", "/msg/")
        return lambda data: self.store.deserialize_ros1(data, full)

    def encode(self, name: str) -> Callable[[Any], Any]:
        full = name.replace("/", "/msg/")
        return lambda message: self.store.serialize_ros1(message, full)


def rows() -> Iterator[tuple[str, str, Any]]:
    """Label, type and a message of ours (lists make a row of list inputs)."""
    import numpy as np

    def make(type_name: str, **fields: Any) -> Any:
        return message_class(type_name)(**fields)

    def header() -> Any:
        message = make("std_msgs/Header", seq=7, frame_id="base_link")
        message.stamp.secs, message.stamp.nsecs = 1700000000, 123456789
        return message

    def vector(kind: str = "Vector3") -> Any:
        return make(f"geometry_msgs/{kind}", x=1.0, y=2.0, z=3.0)

    yield "Float64", "std_msgs/Float64", make("std_msgs/Float64", data=1.5)
    yield "Twist", "geometry_msgs/Twist", make("geometry_msgs/Twist", linear=vector(), angular=vector())
    odometry = make("nav_msgs/Odometry", header=header(), child_frame_id="base_footprint")
    odometry.pose.covariance[:] = range(36)
    yield "Odometry", "nav_msgs/Odometry", odometry
    yield "Imu", "sensor_msgs/Imu", make("sensor_msgs/Imu", header=header(), angular_velocity=vector())
    status = message_class(_status_type())()
    for field in status._spec.fields:
        if field.type.base == "string" and not field.type.is_array:
            setattr(status, field.name, "some text")
    yield f"{_status_type().partition('/')[2]}", _status_type(), status
    yield "two, texts differ", _status_type(), status
    points = [vector("Point32") for _ in range(8)]
    yield "Polygon 8", "geometry_msgs/Polygon", make("geometry_msgs/Polygon", points=points)
    transforms = [
        make("geometry_msgs/TransformStamped", header=header(), child_frame_id=f"link_{i:02}")
        for i in range(20)
    ]
    yield "TFMessage 20", "tf2_msgs/TFMessage", make("tf2_msgs/TFMessage", transforms=transforms)
    yield "TFMessage 1", "tf2_msgs/TFMessage", make("tf2_msgs/TFMessage", transforms=transforms[:1])
    scan = np.linspace(0, 10, 1080, dtype="f4")
    yield (
        "LaserScan 1080x2",
        "sensor_msgs/LaserScan",
        make("sensor_msgs/LaserScan", header=header(), ranges=scan, intensities=scan),
    )
    poses = [make("geometry_msgs/PoseStamped", header=header()) for _ in range(1000)]
    yield "Path 1000", "nav_msgs/Path", make("nav_msgs/Path", header=header(), poses=poses)
    for label, width, height in (("Image VGA", 640, 480), ("Image 1080p", 1920, 1080)):
        pixels = np.zeros(width * height * 3, "u1")
        yield (
            label,
            "sensor_msgs/Image",
            make(
                "sensor_msgs/Image", header=header(), encoding="rgb8", width=width, height=height, data=pixels
            ),
        )
    cloud = np.zeros(4_900_000, "u1")
    fields = [make("sensor_msgs/PointField", name=n, count=1) for n in "xyz"]
    yield (
        "PointCloud2 4.9 MB",
        "sensor_msgs/PointCloud2",
        make("sensor_msgs/PointCloud2", header=header(), fields=fields, data=cloud),
    )
    cells = np.zeros(4_000_000, "i1")
    yield (
        "OccupancyGrid 4 MB",
        "nav_msgs/OccupancyGrid",
        make("nav_msgs/OccupancyGrid", header=header(), data=cells),
    )
    yield (
        "Image VGA (bytes)",
        "sensor_msgs/Image",
        make("sensor_msgs/Image", header=header(), encoding="rgb8", data=bytes(921600)),
    )
    yield (
        "LaserScan 1080x2 (lists)",
        "sensor_msgs/LaserScan",
        make("sensor_msgs/LaserScan", header=header(), ranges=scan.tolist(), intensities=scan.tolist()),
    )
    yield (
        "OccupancyGrid 40 kB (list)",
        "nav_msgs/OccupancyGrid",
        make("nav_msgs/OccupancyGrid", header=header(), data=[0] * 40000),
    )
    yield "String", "std_msgs/String", make("std_msgs/String", data="hello, world")
    yield "Header", "std_msgs/Header", header()


def _status_type() -> str:
    return (
        "woosh_msgs/RobotStatus"
        if "woosh_msgs/RobotStatus" in bundled().messages("woosh_msgs")
        else ("actionlib_msgs/GoalStatus")
    )


def line(label: str, name: str, message: Any, genpy_class: Any, rosbags: Rosbags | None, rounds: int) -> str:
    """One row: time everything in turns."""
    cls = message_class(name)
    data = encode(message)
    fast_encode, fast_decode, size = encoder(cls), decoder(cls), len(data)
    if "(" not in label:  # both sides encode what they decoded; it lies in memory alike
        message = fast_decode(data, 0, size)
    names: dict[str, Any] = {
        "message": message,
        "data": data,
        "size": size,
        "cls": cls,
        "fast_encode": fast_encode,
        "fast_decode": fast_decode,
        "encode": encode,
        "decode": decode,
        "use_ours": reader_of(cls),
        "ready": fast_decode(data, 0, size),
    }
    tasks = {
        "enc": "fast_encode(message)",
        "dec": "fast_decode(data, 0, size)",
        "face enc": "encode(message)",
        "face dec": "decode(cls, data)",
        "use": "use_ours(fast_decode(data, 0, size))",
        "memcpy": "bytearray(data)",
        "read": "use_ours(ready)",
    }
    if genpy_class is not None:
        theirs = genpy_class(name)
        peer = theirs().deserialize(data)
        if "list" in label:
            _lists(peer, message)
        buffer = io.BytesIO()
        names.update(buffer=buffer, seek=buffer.seek, peer=peer, theirs=theirs, use_theirs=names["use_ours"])
        # Small ones write on and on, so that genpy does not pay for the seek.
        tasks["genpy enc"] = "peer.serialize(buffer)" + ("; seek(0)" if size > 1000 else "")
        tasks["genpy dec"] = "theirs().deserialize(data)"
        tasks["genpy use"] = "use_theirs(theirs().deserialize(data))"
        tasks["genpy read"] = "use_theirs(peer)"
    if rosbags is not None:
        names.update(bag_decode=rosbags.decode(name), bag_encode=rosbags.encode(name))
        names["decoded"] = names["bag_decode"](data)
        tasks["bag enc"] = "bag_encode(decoded)"
        tasks["bag dec"] = "bag_decode(data)"
    if "texts" in label:
        tasks = _alternating(tasks, names)
    t = interleaved({key: timer(text, names) for key, text in tasks.items()}, rounds)

    def ratio(theirs: str, ours: str) -> str:
        return f"{t[theirs] / t[ours]:.2f}" if theirs in t and ours in t else "-"

    return (
        f"{label:28} {t['enc'] * 1e6:8.2f} {t['dec'] * 1e6:8.2f} |"
        f" {ratio('genpy enc', 'enc'):>6} {ratio('genpy dec', 'dec'):>6}"
        f" {ratio('genpy enc', 'face enc'):>6} {ratio('genpy dec', 'face dec'):>6} {ratio('genpy use', 'use'):>6}"
        f" {ratio('read', 'genpy read'):>8} | {ratio('bag enc', 'enc'):>9} {ratio('bag dec', 'dec'):>6}"
        f" | {t['enc'] / t['memcpy']:8.2f}"
    )


def _alternating(tasks: dict[str, str], names: dict[str, Any]) -> dict[str, str]:
    """Each statement also for a message of the same size with other texts: nothing can be known of them."""
    other = copy.deepcopy(names["message"])
    for name in other.__slots__:
        if isinstance(getattr(other, name), str):
            setattr(other, name, getattr(other, name).swapcase())
    names.update(message2=other, data2=encode(other))
    if "theirs" in names:
        names["peer2"] = names["theirs"]().deserialize(names["data2"])
    if "bag_decode" in names:
        names["decoded2"] = names["bag_decode"](names["data2"])
    return {
        key: f"{text}; " + re.sub(r"\b(message|data|peer|decoded)\b", r"\g<1>2", text)
        for key, text in tasks.items()
    }


def _lists(peer: Any, message: Any) -> None:
    for name in message.__slots__:
        if isinstance(getattr(message, name), list):
            setattr(peer, name, list(getattr(message, name)))


def reader_of(cls: Any) -> Callable[[Any], None]:
    """A generated function that reads every field of a message once (an array is one field)."""
    lines = ["def read(m):"]
    counter = iter(range(1 << 30))

    def walk(spec: Any, var: str, depth: int) -> None:
        pad = "    " * depth
        for field in spec.fields:
            inner = f"v{next(counter)}"
            lines.append(f"{pad}{inner} = {var}.{field.name}")
            if field.type.base in ("time", "duration") and not field.type.is_array:
                lines.append(f"{pad}{inner}.secs; {inner}.nsecs")
            elif not field.type.is_builtin and field.type.is_array:
                item = f"v{next(counter)}"
                lines.append(f"{pad}for {item} in {inner}:")
                lines.append(f"{pad}    pass")
                walk(bundled().message(field.type.base), item, depth + 1)
            elif not field.type.is_builtin:
                walk(bundled().message(field.type.base), inner, depth)
        lines.append(f"{pad}pass")

    walk(cls._spec, "m", 1)
    namespace: dict[str, Any] = {}
    exec("\n".join(lines), namespace)
    return namespace["read"]  # type: ignore[no-any-return]


def timer(statement: str, names: dict[str, Any]) -> Callable[[int], float]:
    """A function that takes a number of repetitions and gives seconds; nothing but the statement is timed."""
    return timeit.Timer(statement, setup="gc.enable()", globals={**names, "gc": gc}).timeit


def interleaved(tasks: dict[str, Callable[[int], float]], rounds: int) -> dict[str, float]:
    """Seconds per call: the median over rounds, of the best of four turns that all tasks take by turns."""
    repeats = {}
    for name, task in tasks.items():
        task(1)
        repeats[name] = max(2, min(10000, int(0.005 / max(task(1), 1e-7))))
    samples: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(rounds):
        turns = [
            {name: task(repeats[name]) / repeats[name] for name, task in tasks.items()} for _ in range(4)
        ]
        for name, sample in samples.items():
            sample.append(min(turn[name] for turn in turns))
    return {name: statistics.median(values) for name, values in samples.items()}


def every_message(rosbags: Rosbags, rounds: int) -> None:
    """Default values of every message of msgdefs beside rosbags: slower ones are listed."""
    slower, total = [], 0
    library = bundled()
    for package in library.packages():
        for name in library.messages(package):
            cls = message_class(name)
            message = cls()
            data = encode(message)
            try:
                bag_decode, bag_encode = rosbags.decode(name), rosbags.encode(name)
                decoded = bag_decode(data)
                bag_encode(decoded)
            except Exception:
                continue
            total += 1
            names = {"e": encoder(cls), "d": decoder(cls), "m": message, "b": data, "n": len(data)}
            names.update(be=bag_encode, bd=bag_decode, bm=decoded)
            tasks = {"e": "e(m)", "d": "d(b, 0, n)", "be": "be(bm)", "bd": "bd(b)"}
            t = interleaved({key: timer(text, names) for key, text in tasks.items()}, min(rounds, 3))
            if t["e"] > t["be"] or t["d"] > t["bd"]:
                slower.append(f"{name}: encode {t['be'] / t['e']:.2f}x, decode {t['bd'] / t['d']:.2f}x")
    print(f"every message beside rosbags: {total} types, slower in {len(slower)}")
    for text in slower:
        print("  " + text)
