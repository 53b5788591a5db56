"""PyKDL's geometry: constructors, arithmetic, angles at their edges, texts; as transform helpers use it."""

import copy
import math
import pickle
import random

import PyKDL
from PyKDL import Frame, Rotation, Twist, Vector, Wrench, addDelta, diff, dot


def show(*values):
    """Print, the numbers rounded beyond what machines differ in."""
    print(*[rounded(value) for value in values])


def rounded(value):
    """Floats and tuples of them."""
    if isinstance(value, float):
        return round(value, 9) + 0.0
    if isinstance(value, tuple):
        return tuple(rounded(one) for one in value)
    return value


random.seed(7)
v, w = Vector(1, 2.5, -3), Vector(0.5, -1, 4)
show(v, repr(w), v + w, v - w, -v, v * w, v * 2, 2 * v, v / 2, dot(v, w), v == w, v == Vector(v), v != w)
show(v.x(), v.y(), v.z(), v[0], v.Norm(), Vector.Zero(), Vector())
u = Vector(v)
u[1] = 7
u.x(9)
u += v
u -= w
show(u, u.Normalize(), u, Vector().Normalize())
u.ReverseSign()
show(u)
for turn in (
    [Rotation.RPY(*[random.uniform(-3, 3) for _ in range(3)]) for _ in range(6)]
    + [Rotation.Rot(Vector(*axis), angle) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (-1, 2, 3))
       for angle in (0, 1e-9, 0.3, -2, math.pi / 2, math.pi, 3.5)]
    + [Rotation.RPY(0.4, math.pi / 2, 0.3), Rotation.RPY(0.4, -math.pi / 2, 0.3), Rotation(),
       Rotation.EulerZYX(0.1, 0.2, 0.3), Rotation.EulerZYZ(0.1, 0.2, 0.3), Rotation.EulerZYZ(0.1, 0, 0.3),
       Rotation.EulerZYZ(0.1, math.pi, 0.3), Rotation.Quaternion(0, 0, 0, 1), Rotation.Quaternion(0.5, 0.5, 0.5, 0.5),
       Rotation.Quaternion(0, 0, 0.7071067811865476, 0.7071067811865476), Rotation.Identity(),
       Rotation(v, w, v * w)]
):  # fmt: skip
    quaternion = turn.GetQuaternion()
    show(quaternion, tuple(turn.GetRPY()), tuple(turn.GetEulerZYZ()), tuple(turn.GetEulerZYX()))
    if abs(sum(q * q for q in quaternion) - 1) < 1e-6:
        angle, axis = turn.GetRotAngle()
        if abs(angle - math.pi) > 1e-6:
            show(angle, axis)
        else:  # either direction is right, and rounding decides
            show(angle, Rotation.Rot(axis, angle) == turn)
r = Rotation.RPY(0.1, 0.2, 0.3)
show(r, r * v, r.Inverse(), r.Inverse(v), r.UnitX(), r.UnitY(), r.UnitZ(), r[0, 1], r == Rotation(r), r * r)
r.DoRotX(0.2)
r.DoRotY(0.3)
r.DoRotZ(0.4)
show(r)
r.SetInverse()
r[0, 0] = 5
show(
    r,
    Rotation.RotX(1),
    Rotation.RotY(1),
    Rotation.RotZ(1),
    Rotation.Rot2(Vector(0, 0, 1), 1),
    Rotation(*range(9)),
)
f = Frame(Rotation.RPY(0.1, 0.2, 0.3), v)
g = Frame(Rotation.RotZ(1))
show(
    f,
    repr(g),
    f * g,
    f * v,
    f.Inverse(),
    f.Inverse(v),
    f.Inverse() * f == Frame.Identity(),
    Frame(v),
    Frame(),
)
show(f[0, 3], f[1, 2], f.p.x(), f.M.GetRPY()[2])
f.p[2] = 4
f.p.x(7)
f.M = Rotation.RotX(0.5)
f.p += Vector(1, 1, 1)
show(f, Frame.DH(1, 2, 3, 4), Frame.DH_Craig1989(1, 2, 3, 4))
t, x = Twist(v, w), Wrench(v, w)
show(
    t,
    x,
    t + t,
    t - t,
    -t,
    t * 2,
    2 * x,
    x / 2,
    f * t,
    f * x,
    r.Inverse() * t,
    t.RefPoint(v),
    x.RefPoint(v),
    t[4],
)
t.vel[0] = 11
t.rot = Vector(1, 0, 0)
t[5] = 3
show(t, t.vel, dot(t, x), Twist.Zero(), Twist(), t == Twist(t), f.Inverse(t))
show(
    diff(v, w),
    diff(f.M, g.M),
    diff(f, g),
    diff(f, g, 2.0),
    diff(t, Twist(w, v)),
    addDelta(f, t),
    addDelta(v, w, 0.5),
)
show(addDelta(f.M, v, 0.1), PyKDL.Equal(v, w), PyKDL.Equal(v, w, 100), PyKDL.Equal(f, f))
f.Integrate(Twist(v, w), 10)
show(f)
for it in (v, f.M, f, t, x):
    print(
        copy.copy(it) == it, copy.deepcopy(it) == it, pickle.loads(pickle.dumps(it)) == it, it == 1, it != 1
    )
for attempt in (
    lambda: v[3],
    lambda: r[3, 0],
    lambda: f[3, 3],
    lambda: Vector(1, 2),
    lambda: Vector("a"),
    lambda: hash(v),
):
    try:
        attempt()
    except Exception as error:
        print(type(error).__name__)
c = Vector(1, 2, 3)
d = c
d += v
show(c, d is c)
