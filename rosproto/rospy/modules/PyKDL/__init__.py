"""PyKDL's geometry: vectors, rotations, frames, twists, wrenches. Its chains and solvers are C++ only.

Served when the real one is not installed. Source: orocos-kdl 1.5, as measured: results, texts, conventions.
"""

from ._frame import Frame, Rotation
from ._vectors import Equal, Twist, Vector, Wrench, dot

__all__ = ["Equal", "Frame", "Rotation", "Twist", "Vector", "Wrench", "addDelta", "diff", "dot"]

for _made in (Equal, Frame, Rotation, Twist, Vector, Wrench):
    _made.__module__ = __name__  # pickles name them so


def __getattr__(name):
    if name.startswith("__"):
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    raise ImportError(
        "PyKDL.%s: without the real PyKDL there are only Vector, Rotation, Frame, Twist, Wrench, dot, diff, "
        "addDelta and Equal; chains, trees and solvers are C++: install PyKDL "
        "(conda: python-orocos-kdl, Debian: python3-pykdl)" % name,
        name=__name__,
    )


def diff(a, b, dt=1.0):
    """The velocity that takes `a` to `b` in `dt` seconds, in the frame in which both are given."""
    if isinstance(a, Rotation):
        return a * (a.Inverse() * b).GetRot() / dt
    if isinstance(a, Frame):
        return Twist(diff(a.p, b.p, dt), diff(a.M, b.M, dt))
    return (b - a) / dt


def addDelta(a, da, dt=1.0):
    """Where `a` is after moving with the velocity `da` for `dt` seconds."""
    if isinstance(a, Rotation):
        own = a.Inverse() * da
        return a * Rotation.Rot(own, own.Norm() * dt)
    if isinstance(a, Frame):
        return Frame(addDelta(a.M, da.rot, dt), addDelta(a.p, da.vel, dt))
    return a + da * dt
