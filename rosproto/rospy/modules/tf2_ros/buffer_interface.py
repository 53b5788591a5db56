"""tf2_ros.BufferInterface: transforms stamped data of registered types."""

from copy import deepcopy

import rospy
from std_msgs.msg import Header

ZERO = rospy.Duration(0.0)


class TypeException(Exception):
    """A type cannot be transformed or converted."""

    def __init__(self, errstr):
        self.errstr = errstr


class NotImplementedException(Exception):
    """The buffer does not implement lookups."""

    def __init__(self):
        self.errstr = "CanTransform or LookupTransform not implemented"


def Stamped(obj, stamp, frame_id):
    """Add a header to an object."""
    obj.header = Header(frame_id=frame_id, stamp=stamp)
    return obj


def _found(functions, key):
    """The function of a type.

    Raises:
        TypeException: The type has no function.
    """
    if key not in functions:
        raise TypeException("Type %s if not loaded or supported" % str(key))
    return functions[key]


class TransformRegistration:
    """Transform functions by type, of all objects: `function(data, transform) -> data`."""

    _functions = {}

    def print_me(self):
        """Print the table."""
        print(self._functions)

    def add(self, key, callback):
        """Register the function of a type."""
        self._functions[key] = callback

    def get(self, key):
        """The function of a type."""
        return _found(self._functions, key)


class ConvertRegistration:
    """Conversion functions, of all objects: to a message, from a message, or directly."""

    _to, _from, _straight = {}, {}, {}

    def add_to_msg(self, key, callback):
        """Register a function that converts a type to a message."""
        self._to[key] = callback

    def add_from_msg(self, key, callback):
        """Register a function that converts a message to a type."""
        self._from[key] = callback

    def add_convert(self, key, callback):
        """Register a direct function for a pair of types."""
        self._straight[key] = callback

    def get_to_msg(self, key):
        """The function that converts a type to a message."""
        return _found(self._to, key)

    def get_from_msg(self, key):
        """The function that converts a message to a type."""
        return _found(self._from, key)

    def get_convert(self, key):
        """The direct function of a pair of types."""
        return _found(self._straight, key)


def convert(a, b_type):
    """Convert an object to another type; through a message if there is no direct function."""
    table = ConvertRegistration()
    if type(a) is b_type:
        return deepcopy(a)
    try:
        return table.get_convert((type(a), b_type))(a)
    except TypeException:
        return table.get_from_msg(b_type)(table.get_to_msg(type(a))(a))


class BufferInterface:
    """Base class that implements `transform` with a subclass's `lookup_transform`."""

    def __init__(self):
        self.registration = TransformRegistration()

    def transform(self, object_stamped, target_frame, timeout=ZERO, new_type=None):
        """Transform stamped data to another frame."""
        function = self.registration.get(type(object_stamped))
        header = object_stamped.header
        moved = function(
            object_stamped, self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        )
        return convert(moved, new_type) if new_type else moved

    def transform_full(
        self, object_stamped, target_frame, target_time, fixed_frame, timeout=ZERO, new_type=None
    ):
        """As `transform`, between two times."""
        function = self.registration.get(type(object_stamped))
        header = object_stamped.header
        transform = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        moved = function(object_stamped, transform)
        return convert(moved, new_type) if new_type else moved

    def lookup_transform(self, *args, **kwds):
        """Defined by subclasses, as are the others."""
        raise NotImplementedException

    lookup_transform_full = can_transform = can_transform_full = lookup_transform
