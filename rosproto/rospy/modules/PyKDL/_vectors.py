"""Vectors, and the pairs of them: twists and wrenches. Their base classes are lists of numbers."""

from math import sqrt

EPS = 1e-6


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

    def __copy__(self):
        return type(self)(self)

    def __deepcopy__(self, memo):
        return type(self)(self)

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
        return (
            self._of([a + b for a, b in zip(self._n, other._n)])
            if type(other) is type(self)
            else NotImplemented
        )

    def __sub__(self, other):
        return (
            self._of([a - b for a, b in zip(self._n, other._n)])
            if type(other) is type(self)
            else NotImplemented
        )

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

    def __reduce__(self):
        return Vector, tuple(self._n)

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


def rotated(pair, rotation):
    """Both vectors of a pair, rotated."""
    return type(pair)(rotation * pair._first, rotation * pair._second)


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
