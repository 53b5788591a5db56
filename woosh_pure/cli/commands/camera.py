"""`woosh camera`."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from pathlib import Path

from rosproto.sentence import say
from woosh_pure.cli.arguments import add_wait, png_file, wait_for, write
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.values.state import Image

HELP = "take a picture, in colour or of depth, and save it"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_wait(parser)
    parser.add_argument(
        "--depth", action="store_true", help="the depth image: near is bright, not measured is black"
    )
    parser.add_argument(
        "--millimetres", action="store_true", help="with --depth: as data, 16-bit grey in mm (looks black)"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "-o",
        "--png",
        type=png_file,
        metavar="FILE",
        help="where to write it (default: camera-DATE-TIME.png in this folder)",
    )
    where.add_argument("--no-file", action="store_true", help="write nothing, only tell about it")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.millimetres and not args.depth:
        raise ValueError("--millimetres is about the depth image: give --depth too")
    with connect(args, out) as chassis:
        image = wait_for(chassis.depth if args.depth else chassis.camera, args, out)
    height, width = image.pixels.shape[:2]
    facts = {"width": width, "height": height, "encoding": image.encoding, "frame": image.frame}
    out.line(say("{width} x {height} {encoding} in {frame}", **facts))
    if args.depth:
        import numpy as np

        metres = image.depth_metres()
        seen = metres[np.isfinite(metres) & (metres > 0.0)]
        facts["nearest"] = nearest = float(seen.min()) if seen.size else None
        facts["farthest"] = farthest = float(seen.max()) if seen.size else None
        out.line(
            "nothing measured"
            if nearest is None
            else say("from {nearest:.2f} m to {farthest:.2f} m", nearest=nearest, farthest=farthest)
        )
    if not args.no_file:
        file = args.png or _free_name("depth" if args.depth else "camera")
        facts["file"] = write(file, image_png(image, millimetres=args.millimetres), out)
    out.result(facts)
    return 0


def _free_name(kind: str) -> Path:
    """Return an unused file name with the time."""
    stem = f"{kind}-{time.strftime('%Y%m%d-%H%M%S')}"
    path, number = Path(f"{stem}.png"), 2
    while path.exists():
        path, number = Path(f"{stem}-{number}.png"), number + 1
    return path


def image_png(image: Image, *, millimetres: bool = False) -> bytes:
    """Convert a camera image to PNG; depth is scaled to its range: near is bright, not measured is black.

    Args:
        image: The camera's image.
        millimetres: True for depth as 16-bit grey in mm, 0 for not measured. It looks black.

    Raises:
        ValueError: The encoding is not supported.
    """
    from rosproto.numeric import depth_millimetres, encode_png, picture_order, visible_depth

    pixels = image.pixels
    if image.encoding in ("16UC1", "mono16", "32FC1"):
        metres = image.depth_metres()
        return encode_png(depth_millimetres(metres) if millimetres else visible_depth(metres))
    order = picture_order(image.encoding)
    return encode_png(pixels if order is None else pixels[..., order])
