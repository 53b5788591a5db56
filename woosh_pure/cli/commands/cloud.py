"""`woosh cloud`: the point cloud of the depth camera."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.cli import counted
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_wait, folder_exists, wait_for, write
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.values.state import PointCloud

HELP = "take a point cloud of the depth camera, as a PLY file"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_wait(parser)
    parser.add_argument("--obstacles", action="store_true", help="only obstacles, the ground removed")
    parser.add_argument(
        "-o", "--ply", type=folder_exists, metavar="FILE", help="where to write it (binary PLY, m)"
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis:
        cloud = wait_for(chassis.obstacle_points if args.obstacles else chassis.points, args, out)
    points = cloud.points
    out.line(say("{points} in {frame}", points=counted(len(points), "point"), frame=cloud.frame))
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (None, None)
    if low is not None and high is not None:
        for axis, a, b in zip("xyz", low, high, strict=True):
            out.line(" ", say("{axis} {lowest:+.3f} to {highest:+.3f} m", axis=axis, lowest=a, highest=b))
    file = write(args.ply, ply(cloud), out) if args.ply else None
    out.result({"points": len(points), "frame": cloud.frame, "low": low, "high": high, "file": file})
    return 0


def ply(cloud: PointCloud) -> bytes:
    """Return a binary PLY file (paulbourke.net/dataformats/ply): x, y, z float in m."""
    head = (
        "ply",
        "format binary_little_endian 1.0",
        f"comment frame {cloud.frame}",
        f"element vertex {len(cloud.points)}",
        *(f"property float {axis}" for axis in "xyz"),
        "end_header",
        "",
    )
    return "\n".join(head).encode("ascii", "replace") + cloud.points.astype("<f4").tobytes()
