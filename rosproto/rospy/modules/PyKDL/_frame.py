"""Frames: poses."""

from ._numbers import Numbers
from ._rotation import Rotation
from ._vectors import Twist, Vector, Wrench


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
