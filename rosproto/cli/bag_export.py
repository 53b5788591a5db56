"""`rosproto bag export`: export messages as CSV, PNG, NPZ, MCAP or Parquet."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, TextIO

from rosproto.bag import BagReader
from rosproto.cli.bag_edit import add_span_arguments, span, wanted_topics, write
from rosproto.cli.bag_files import MCAP_COMPRESSION, check_new, decodable, named, next_to, opened, whole
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import counted
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.export_parquet import need, new_paths, write_parquet
from rosproto.cli.fields import header, parse_field_path, row
from rosproto.cli.options import add_allow_damaged, add_quiet
from rosproto.codec import Message

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosproto.codec import DynamicMessage
    from rosproto.time import Time


def add_export_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options for messages and format."""
    parser.add_argument("bag", metavar="BAG")
    parser.add_argument(
        "form",
        nargs="?",
        choices=sorted(FORMS),
        help="csv, npz, parquet: one file per topic; png: one file per image; mcap: one file",
    )
    parser.add_argument("--format", choices=sorted(FORMS), help="the same, as an option")
    parser.add_argument(
        "-o",
        "--output",
        metavar="PATH",
        help="a directory (mcap: a file; parquet of one topic: also a file); default: next to the bag",
    )
    parser.add_argument(
        "--fields", nargs="+", metavar="FIELD", help="csv, npz, parquet: only these: pose.pose.position.x"
    )
    parser.add_argument(
        "--scale-depth", action="store_true", help="png: depth to look at, instead of 16-bit millimetres"
    )
    add_allow_damaged(parser)
    add_quiet(parser)
    add_span_arguments(parser)


def export(arguments: argparse.Namespace) -> None:
    """Export the selected messages, and print each file's name."""
    if (arguments.form is None) == (arguments.format is None):
        raise CommandError(f"name one format: {', '.join(sorted(FORMS))}, as BAG csv or --format csv")
    form = arguments.form or arguments.format
    with opened(arguments.bag, arguments, quiet=arguments.quiet) as bag:
        topics = wanted_topics(bag, arguments)
        if form != "mcap":  # which takes the messages as they are
            topics = decodable(bag, topics, arguments)
        for path in FORMS[form](bag, topics, arguments):
            if not arguments.quiet:
                print(path)


def _messages(
    bag: BagReader, topics: list[str], arguments: argparse.Namespace
) -> Iterator[tuple[str, DynamicMessage, Time]]:
    start, end = span(bag, arguments)
    return bag.read_messages(topics, start, end)


def _total(bag: BagReader, topics: list[str]) -> int:
    return sum(bag.topics[topic].message_count for topic in topics)


# -- CSV ---------------------------------------------------------------------------------------------------


def _csv(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """Write a file per topic, with the column names of `rostopic echo -p`."""
    paths = new_paths(bag, topics, arguments, ".csv")
    files: dict[str, _CsvFile] = {}
    with (
        ExitStack() as stack,
        Progress("writing CSV", _total(bag, topics), quiet=arguments.quiet) as progress,
    ):
        for topic, message, stamp in _messages(bag, topics, arguments):
            if topic not in files:
                stack.enter_context(whole(paths[topic]))
                files[topic] = _CsvFile(paths[topic], arguments.fields)
                stack.callback(files[topic].close)
            files[topic].write(message, stamp.to_nsec())
            progress.step()
    return [file.path for file in files.values()]


class _CsvFile:
    """The CSV file of a topic; arrays of varying length give rows of varying length, as in rostopic."""

    def __init__(self, path: str, fields: list[str] | None) -> None:
        self.path = path
        self._columns = [
            (f"field.{field}", parse_field_path(field.replace(".", "/"))) for field in fields or ()
        ] or [("field", parse_field_path(""))]
        self._file: TextIO = open(path, "w", encoding="utf-8", newline="")  # noqa: SIM115
        self._begun = False

    def write(self, message: object, receive_ns: int) -> None:
        values = [(name, take(message)) for name, take in self._columns]
        lines = [[str(receive_ns), *(cell for _, value in values for cell in row(value))]]
        if not self._begun:
            lines.insert(0, ["%time", *(column for name, value in values for column in header(value, name))])
            self._begun = True
        with named(self.path):
            self._file.writelines(",".join(cells) + "\n" for cells in lines)

    def close(self) -> None:
        with named(self.path):
            self._file.close()


# -- NPZ ---------------------------------------------------------------------------------------------------


def _npz(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """Write a file per topic, an array per field; strings and arrays of varying length have dtype object."""
    from rosproto.bag.columns import to_numpy

    paths = new_paths(bag, topics, arguments, ".npz")
    with Progress("writing NPZ", _total(bag, topics), quiet=arguments.quiet) as progress:
        for topic in topics:
            fields = arguments.fields or _leaves(bag.message_class(topic))
            columns = to_numpy(bag, topic, bag.topics[topic].connections, fields, progress.step)
            keep = _span_mask(bag, arguments, next(iter(columns.values())))
            columns = {name: column[keep] for name, column in columns.items()}
            with whole(paths[topic]):
                _write_npz(paths[topic], columns)
    return list(paths.values())


def _write_npz(path: str, columns: Mapping[str, NDArray[np.generic]]) -> None:
    """Like numpy.savez_compressed, which cannot write an array named `file`."""
    import zipfile

    import numpy as np

    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, column in columns.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(column))


def _span_mask(
    bag: BagReader, arguments: argparse.Namespace, times: NDArray[np.float64]
) -> NDArray[np.bool_]:
    import numpy as np

    start, end = span(bag, arguments)
    mask = np.ones(len(times), bool)
    if start is not None:
        mask &= times >= start.to_sec()
    if end is not None:
        mask &= times <= end.to_sec()
    return mask


def _leaves(cls: type[Message], prefix: str = "") -> list[str]:
    """Return the paths of all leaf fields; arrays of messages have no columns."""
    message, found = cls(), []
    for name, kind in zip(cls.__slots__, cls._slot_types, strict=True):
        value = getattr(message, name)
        if isinstance(value, Message):
            found += _leaves(type(value), f"{prefix}{name}.")
        elif "/" not in kind:
            found.append(prefix + name)
    return found


# -- PNG ---------------------------------------------------------------------------------------------------


def _png(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """Write a file per image, named by its receive time, in a new folder per topic."""
    images = [topic for topic in topics if bag.topics[topic].connections[0].type in IMAGES]
    if not images:
        raise CommandError(f"{bag.path}: none of the topics has images ({', '.join(IMAGES)})")
    folders, paths = new_paths(bag, images, arguments, ""), []
    written: set[str] = set()
    with Progress("writing PNG", _total(bag, images), quiet=arguments.quiet) as progress:
        for topic, message, stamp in _messages(bag, images, arguments):
            os.makedirs(folders[topic], exist_ok=True)
            path = _free(os.path.join(folders[topic], f"{stamp.secs}.{stamp.nsecs:09d}"), ".png", written)
            picture = png_of(message, scale_depth=arguments.scale_depth)
            with whole(path), open(path, "wb") as file:
                file.write(picture)
            paths.append(path)
            progress.step()
    return paths


def _free(path: str, ending: str, written: set[str]) -> str:
    """Return the path, with a number appended if this export has already written it (equal times)."""
    name, number = path + ending, 1
    while name in written:
        number += 1
        name = f"{path}-{number}{ending}"
    written.add(name)
    return name


# -- MCAP --------------------------------------------------------------------------------------------------


def _mcap(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """Write one file in the ros1 profile with unchanged messages; Foxglove opens it."""
    need("mcap.writer", "mcap", "mcap")
    path = arguments.output or next_to(arguments.bag) + ".mcap"
    check_new([path], arguments.bag)
    entries = bag.read_messages(topics, *span(bag, arguments), raw=True)
    write(path, entries, MCAP_COMPRESSION, _total(bag, topics), mcap=True, quiet=arguments.quiet)
    return [path]


Form = Callable[["BagReader", list[str], argparse.Namespace], list[str]]
FORMS: dict[str, Form] = {"csv": _csv, "npz": _npz, "png": _png, "mcap": _mcap, "parquet": write_parquet}


# -- pictures -----------------------------------------------------------------------------------------------
# sensor_msgs/Image and CompressedImage as PNG; only CompressedImage needs Pillow.
#
# Source: REP 118 for depth images.


IMAGES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")

DEPTH = ("16UC1", "32FC1")


def png_of(message: DynamicMessage, *, scale_depth: bool = False) -> bytes:
    """Convert a message to PNG; Bayer patterns stay raw, depth becomes 16-bit grey in mm.

    Args:
        message: A sensor_msgs/Image or CompressedImage.
        scale_depth: Scale each depth image to its own range, for display.

    Raises:
        CommandError: Unknown encoding, data that do not match the size, or Pillow is missing.
    """
    from rosproto.numeric.pngfile import encode_png, is_png

    if message._type == "sensor_msgs/CompressedImage":
        data = bytes(message.data)
        return data if is_png(data) else _converted(data)
    pixels = pixels_of(message)
    if scale_depth and message.encoding in DEPTH:
        from rosproto.numeric.images import visible_depth

        pixels = visible_depth(pixels / 1000.0)
    return encode_png(pixels)


def _converted(data: bytes) -> bytes:
    import io

    pillow = need("PIL.Image", "Pillow", "cli")
    file = io.BytesIO()
    try:
        pillow.open(io.BytesIO(data)).save(file, "PNG")
    except (OSError, ValueError) as error:
        raise CommandError(f"a compressed image that cannot be read: {error}") from error
    return file.getvalue()


def pixels_of(message: DynamicMessage) -> NDArray[Any]:
    """Return the pixels of a sensor_msgs/Image, row by row; metres (32FC1) become millimetres."""
    import numpy as np

    from rosproto.numeric.images import PICTURES, depth_millimetres, image_to_array, picture_order

    if message.encoding not in PICTURES:
        raise CommandError(
            f"an image with encoding {message.encoding!r}; known are {', '.join(sorted(PICTURES))}"
        )
    try:
        pixels = image_to_array(message)
    except ValueError as error:
        found = counted(len(message.data), "byte")
        raise CommandError(f"an image should have all its rows, but has {found}: {error}") from error
    if message.encoding == "32FC1":
        return depth_millimetres(pixels)
    order = picture_order(message.encoding)
    pixels = pixels if order is None else pixels[:, :, order]
    return np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("="))
