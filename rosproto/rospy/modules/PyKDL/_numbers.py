"""Base classes of vectors and rotations: lists of numbers."""

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
