"""`woosh camera`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from ..arguments import add_wait, folder_exists, wait_for, write
from ..connection import connect
from ..output import Output

HELP = "take a picture, in colour or of depth"


def add_arguments(parser: ArgumentParser) -> None:
    """See `registry`."""
    add_wait(parser)
    parser.add_argument("--depth", action="store_true", help="the depth image: 16-bit grey, mm")
    parser.add_argument("--png", type=folder_exists, metavar="FILE", help="where to write it")


def run(args: Namespace, out: Output) -> int:
    """See `registry`."""
    with connect(args, out) as chassis:
        image = wait_for(chassis.depth if args.depth else chassis.camera, args, out)
    height, width = image.pixels.shape[:2]
    facts = {"width": width, "height": height, "encoding": image.encoding, "frame": image.frame}
    out.line(f"{width} x {height} {image.encoding} in {image.frame}")
    if args.depth:
        import numpy as np

        metres = image.depth_metres()
        seen = metres[np.isfinite(metres)]
        nearest = float(seen.min()) if seen.size else None
        out.line("nothing measured" if nearest is None else f"nearest {nearest:.2f} m")
        facts["nearest"] = nearest
    if args.png:
        from ..png import image_png

        facts["file"] = write(args.png, image_png(image), out)
    out.result(facts)
    return 0
