"""PyKDL's geometry: vectors, rotations, frames, twists, wrenches. Its chains and solvers are C++ only.

Served when the real one is not installed. Source: orocos-kdl 1.5, as measured: results, texts, conventions.
"""

from math import atan2, cos, pi, sin, sqrt

__all__ = ["Equal", "Frame", "Rotation", "Twist", "Vector", "Wrench", "addDelta", "diff", "dot"]

EPS = 1e-6
_TINY = 1e-12


def __getattr__(name):
    if name.startswith("__"):
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    raise ImportError(
        "PyKDL.%s: without the real PyKDL there are only Vector, Rotation, Frame, Twist, Wrench, dot, diff, "
        "addDelta and Equal; chains, trees and solvers are C++: install PyKDL "
        "(conda: python-orocos-kdl, Debian: python3-pykdl)" % name,
        name=__name__,
    )


def numbers_of(made, args, count):
    """The numbers of a constructor's arguments: none, an object of the class `made`, or `count` numbers."""
    if not args:
        return None
    if len(args) == 1 and isinstance(args[0], made):
        return list(args[0]._n)
    if len(args) != count:
        raise TypeError("%s() takes %d numbers or a %s; not %r" % (made.__name__, count, made.__name__, args))
    return [float(a) for a in args]


def text(numbers):
    return ",".join("%12g" % number for number in numbers)


class Numbers:
    """Numbers in a list `_n`: copying, pickling, comparing; not hashable."""

    __hash__ = None

    def __reduce__(self):  # for copies, too
        return type(self), tuple(self._n)

    def __eq__(self, other):
        return Equal(self, other) if type(other) is type(self) else NotImplemented

    def __repr__(self):
        return str(self)


class Sum(Numbers):
    """Numbers that can be added and scaled."""

    def _of(self, numbers):
        made = type(self)()
        made._n = list(numbers)
        return made

    def __add__(self, other):
        if type(other) is not type(self):
            return NotImplemented
        return self._of([a + b for a, b in zip(self._n, other._n)])

    def __sub__(self, other):
        if type(other) is not type(self):
            return NotImplemented
        return self._of([a - b for a, b in zip(self._n, other._n)])

    def __iadd__(self, other):
        self._n = (self + other)._n
        return self

    def __isub__(self, other):
        self._n = (self - other)._n
        return self

    def __neg__(self):
        return self._of([-a for a in self._n])

    def __mul__(self, factor):
        return self._of([a * factor for a in self._n]) if isinstance(factor, (int, float)) else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, divisor):
        return self._of([a / divisor for a in self._n])

    def __getitem__(self, index):
        if not 0 <= index < len(self._n):
            raise IndexError("%s index out of range" % type(self).__name__)
        return self._n[index]

    def __setitem__(self, index, value):
        self[index]
        self._n[index] = float(value)

    def __str__(self):
        return "[%s]" % text(self._n)

    def ReverseSign(self):
        """Negate it in place."""
        self._n = (-self)._n

    @classmethod
    def Zero(cls):
        """All zero."""
        return cls()


def Equal(a, b, eps=EPS):
    """True when all numbers differ by less than `eps`."""
    return all(abs(one - other) < eps for one, other in zip(a._n, b._n))


def dot(a, b):
    """The product of two vectors, or of a twist and a wrench."""
    return sum(one * other for one, other in zip(a._n, b._n))


class Vector(Sum):
    """Three numbers."""

    def __init__(self, *args):
        self._n = numbers_of(Vector, args, 3) or [0.0, 0.0, 0.0]

    def __mul__(self, other):
        if isinstance(other, Vector):  # the cross product
            (a, b, c), (x, y, z) = self._n, other._n
            return Vector(b * z - c * y, c * x - a * z, a * y - b * x)
        return super().__mul__(other)

    def _axis(index):
        def axis(self, value=None):
            if value is None:
                return self._n[index]
            self._n[index] = float(value)
            return None

        return axis

    x, y, z = _axis(0), _axis(1), _axis(2)

    def Norm(self, eps=EPS):
        """Its length."""
        return sqrt(sum(a * a for a in self._n))

    def Normalize(self, eps=EPS):
        """Scale it to length 1 (a zero vector becomes x); returns the length before."""
        length = self.Norm()
        self._n = [1.0, 0.0, 0.0] if length < eps else [a / length for a in self._n]
        return length


class Pair(Sum):
    """Two vectors."""

    def __init__(self, *args):
        if len(args) == 1:
            args = (args[0]._first, args[0]._second)
        elif len(args) not in (0, 2):
            raise TypeError("%s() takes two Vectors; not %d values" % (type(self).__name__, len(args)))
        self._first, self._second = (Vector(vector) for vector in args or (Vector(), Vector()))

    def __reduce__(self):
        return type(self), (self._first, self._second)

    @property
    def _n(self):
        return self._first._n + self._second._n

    @_n.setter
    def _n(self, numbers):
        self._first._n, self._second._n = list(numbers[:3]), list(numbers[3:])

    def __setitem__(self, index, value):
        self[index]
        (self._first if index < 3 else self._second)[index % 3] = value

    def _named(which):
        def get(self):
            return getattr(self, which)

        def put(self, vector):
            setattr(self, which, Vector(vector))

        return property(get, put)


class Twist(Pair):
    """A linear velocity `vel` and an angular velocity `rot`."""

    vel, rot = Pair._named("_first"), Pair._named("_second")

    def RefPoint(self, v):
        """The same motion, with `v` as reference point."""
        return Twist(self.vel + self.rot * v, self.rot)


class Wrench(Pair):
    """A `force` at a point and a `torque`."""

    force, torque = Pair._named("_first"), Pair._named("_second")

    def RefPoint(self, v):
        """The same load, with `v` as reference point."""
        return Wrench(self.force, self.torque + self.force * v)


class Rotation(Numbers):
    """A rotation: nine numbers of its matrix, row by row, or its three columns as vectors."""

    def __init__(self, *args):
        if len(args) == 3:
            args = [column[row] for row in range(3) for column in args]
        self._n = numbers_of(Rotation, args, 9) or [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]

    def __str__(self):
        return "[%s]" % ";\n ".join(text(self._n[i : i + 3]) for i in (0, 3, 6))

    def __getitem__(self, at):
        row, column = at
        if not (0 <= row < 3 and 0 <= column < 3):
            raise IndexError("Rotation index out of range")
        return self._n[3 * row + column]

    def __setitem__(self, at, value):
        self[at]
        self._n[3 * at[0] + at[1]] = float(value)

    def __mul__(self, other):
        n = self._n
        if isinstance(other, Vector):
            x, y, z = other._n
            return Vector(*[n[i] * x + n[i + 1] * y + n[i + 2] * z for i in (0, 3, 6)])
        if isinstance(other, Rotation):
            return Rotation(*[self * Vector(*other._n[i::3]) for i in range(3)])
        if isinstance(other, Pair):
            return type(other)(self * other._first, self * other._second)
        return NotImplemented

    def Inverse(self, *args):
        """The inverse, or a vector, twist or wrench rotated by it."""
        inverse = Rotation(*[self._n[3 * column + row] for row in range(3) for column in range(3)])
        return inverse * args[0] if args else inverse

    def SetInverse(self):
        """Invert it in place."""
        self._n = self.Inverse()._n

    def _unit(index):
        def unit(self, *args):
            if not args:
                return Vector(*self._n[index::3])
            self._n[index::3] = args[0]._n
            return None

        return unit

    UnitX, UnitY, UnitZ = _unit(0), _unit(1), _unit(2)

    @staticmethod
    def Identity():
        """No rotation."""
        return Rotation()

    @staticmethod
    def RotX(angle):
        """A rotation about x."""
        s, c = sin(angle), cos(angle)
        return Rotation(1, 0, 0, 0, c, -s, 0, s, c)

    @staticmethod
    def RotY(angle):
        """A rotation about y."""
        s, c = sin(angle), cos(angle)
        return Rotation(c, 0, s, 0, 1, 0, -s, 0, c)

    @staticmethod
    def RotZ(angle):
        """A rotation about z."""
        s, c = sin(angle), cos(angle)
        return Rotation(c, -s, 0, s, c, 0, 0, 0, 1)

    def _turn(about):
        def turn(self, angle):
            """Rotate it in place about one of its own axes."""
            self._n = (self * about(angle))._n

        return turn

    DoRotX, DoRotY, DoRotZ = _turn(RotX.__func__), _turn(RotY.__func__), _turn(RotZ.__func__)

    @staticmethod
    def Rot(axis, angle):
        """A rotation about any axis."""
        axis = Vector(axis)
        axis.Normalize()
        return Rotation.Rot2(axis, angle)

    @staticmethod
    def Rot2(axis, angle):
        """A rotation about a unit vector."""
        (x, y, z), s, c = axis._n, sin(angle), cos(angle)
        r = 1 - c
        return Rotation(
            c + r * x * x, r * x * y - z * s, r * x * z + y * s,
            r * x * y + z * s, c + r * y * y, r * y * z - x * s,
            r * x * z - y * s, r * y * z + x * s, c + r * z * z,
        )  # fmt: skip

    @staticmethod
    def RPY(roll, pitch, yaw):
        """From angles about the fixed axes x, y, z."""
        return Rotation.RotZ(yaw) * Rotation.RotY(pitch) * Rotation.RotX(roll)

    @staticmethod
    def EulerZYX(alfa, beta, gamma):
        """From angles about the rotated axes z, y, x."""
        return Rotation.RPY(gamma, beta, alfa)

    @staticmethod
    def EulerZYZ(alfa, beta, gamma):
        """From angles about the rotated axes z, y, z."""
        return Rotation.RotZ(alfa) * Rotation.RotY(beta) * Rotation.RotZ(gamma)

    @staticmethod
    def Quaternion(x, y, z, w):
        """From a quaternion, which is not normalized."""
        return Rotation(
            w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),
            2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
            2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z,
        )  # fmt: skip

    def GetQuaternion(self):
        """(x, y, z, w)."""
        n = self._n
        trace = n[0] + n[4] + n[8]
        if trace > _TINY:
            s = 0.5 / sqrt(trace + 1.0)
            return (n[7] - n[5]) * s, (n[2] - n[6]) * s, (n[3] - n[1]) * s, 0.25 / s
        i = 0 if n[0] > n[4] and n[0] > n[8] else 1 if n[4] > n[8] else 2  # the longest of x, y, z
        j, k = (i + 1) % 3, (i + 2) % 3
        low, high = min(j, k), max(j, k)  # KDL adds in this order
        s = 2.0 * sqrt(1.0 + n[4 * i] - n[4 * low] - n[4 * high])
        found = [0.0, 0.0, 0.0, (n[3 * k + j] - n[3 * j + k]) / s]
        found[i] = 0.25 * s
        found[j] = (n[3 * i + j] + n[3 * j + i]) / s
        found[k] = (n[3 * i + k] + n[3 * k + i]) / s
        return tuple(found)

    def GetRPY(self):
        """(roll, pitch, yaw); roll is 0 where only the sum of roll and yaw is determined."""
        n = self._n
        pitch = atan2(-n[6], sqrt(n[0] * n[0] + n[3] * n[3]))
        if abs(pitch) > pi / 2 - _TINY:
            return 0.0, pitch, atan2(-n[1], n[4])
        return atan2(n[7], n[8]), pitch, atan2(n[3], n[0])

    def GetEulerZYX(self):
        """(z, y, x)."""
        return self.GetRPY()[::-1]

    def GetEulerZYZ(self):
        """(z, y, z); the last is 0 where only their sum is determined."""
        n = self._n
        if abs(n[8]) > 1 - _TINY:
            return (atan2(n[3], n[0]), 0.0, 0.0) if n[8] > 0 else (atan2(-n[3], -n[0]), pi, 0.0)
        return atan2(n[5], n[2]), atan2(sqrt(n[6] * n[6] + n[7] * n[7]), n[8]), atan2(n[7], -n[6])

    def GetRotAngle(self, eps=EPS):
        """(angle, axis)."""
        n = self._n
        if abs(n[1] - n[3]) < eps and abs(n[2] - n[6]) < eps and abs(n[5] - n[7]) < eps:
            return self._half_turn(eps)
        axis = Vector((n[7] - n[5]) / 2, (n[2] - n[6]) / 2, (n[3] - n[1]) / 2)
        angle = atan2(axis.Norm(), (n[0] + n[4] + n[8] - 1) / 2)
        axis.Normalize()
        return angle, axis

    def _half_turn(self, eps):
        """(angle, axis) of a symmetric matrix: no rotation, or half a turn."""
        n = self._n
        diagonal = all(abs(n[i] + n[j]) < eps for i, j in ((1, 3), (2, 6), (5, 7)))
        if diagonal and abs(n[0] + n[4] + n[8] - 3) < eps:
            return 0.0, Vector(0, 0, 1)
        i = max(range(3), key=lambda k: n[4 * k])
        own = sqrt(max((n[4 * i] + 1) / 2, 0.0))
        return pi, Vector(*[own if k == i else (n[3 * i + k] + n[3 * k + i]) / 4 / own for k in range(3)])

    def GetRot(self):
        """The rotation vector: the axis, its length the angle."""
        angle, axis = self.GetRotAngle()
        return axis * angle


class Frame(Numbers):
    """A pose: rotation `M`, position `p`."""

    def __init__(self, *args):
        self.M, self.p = Rotation(), Vector()
        if len(args) == 1 and isinstance(args[0], Frame):
            args = (args[0].M, args[0].p)
        if len(args) > 2:
            raise TypeError("Frame() takes a Rotation, a Vector, both, or a Frame; not %d values" % len(args))
        for part in args:
            if isinstance(part, Rotation):
                self.M = Rotation(part)
            else:
                self.p = Vector(part)  # a TypeError for anything else

    def __reduce__(self):
        return Frame, (self.M, self.p)

    @property
    def _n(self):
        return self.M._n + self.p._n

    def __str__(self):
        return "[%s\n%s]" % (self.M, self.p)

    def __getitem__(self, at):
        row, column = self._within(at)
        return self.p[row] if column == 3 else self.M[row, column]

    def __setitem__(self, at, value):
        row, column = self._within(at)
        if column == 3:
            self.p[row] = value
        else:
            self.M[row, column] = value

    @staticmethod
    def _within(at):
        if not (0 <= at[0] < 3 and 0 <= at[1] < 4):
            raise IndexError("Frame index out of range")
        return at

    def __mul__(self, other):
        if isinstance(other, Vector):
            return self.M * other + self.p
        if isinstance(other, Frame):
            return Frame(self.M * other.M, self * other.p)
        if isinstance(other, Twist):
            rot = self.M * other.rot
            return Twist(self.M * other.vel + self.p * rot, rot)
        if isinstance(other, Wrench):
            force = self.M * other.force
            return Wrench(force, self.M * other.torque + self.p * force)
        return NotImplemented

    def Inverse(self, *args):
        """The inverse pose, or a vector, twist or wrench transformed by it."""
        turn = self.M.Inverse()
        inverse = Frame(turn, -(turn * self.p))
        return inverse * args[0] if args else inverse

    def Integrate(self, t_this, frequency):
        """Move on with a twist in this frame's coordinates, for one period of `frequency`."""
        self.p += self.M * (t_this.vel / frequency)
        self.M = self.M * Rotation.Rot(t_this.rot, t_this.rot.Norm() / frequency)

    @staticmethod
    def Identity():
        """The identity."""
        return Frame()

    @staticmethod
    def DH(a, alpha, d, theta):
        """The frame of Denavit-Hartenberg parameters."""
        return Frame(Rotation.RotZ(theta), Vector(0, 0, d)) * Frame(Rotation.RotX(alpha), Vector(a, 0, 0))

    @staticmethod
    def DH_Craig1989(a, alpha, d, theta):
        """The same in Craig's (modified) convention."""
        return Frame(Rotation.RotX(alpha), Vector(a, 0, 0)) * Frame(Rotation.RotZ(theta), Vector(0, 0, d))


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
