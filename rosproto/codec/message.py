"""Message: the base of all message classes, with genpy's interface.

Source: genpy/message.py; tools written for rospy messages rely on these names.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

from rosproto.codec.binding import Binding, Octets
from rosproto.msg import MessageSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from typing_extensions import Self, Writer

__all__ = ["AnyMsg", "DynamicMessage", "Message", "MessageMeta", "ServiceType"]


class _Lazy:
    """A class attribute that is computed on first access and stored on the class."""

    def __init__(self, name: str, work: Callable[[Binding], object]) -> None:
        self.name = name
        self._work = work

    def __get__(self, instance: object, owner: type[Message]) -> object:
        binding = owner._binding
        if binding is None:
            raise AttributeError(f"{owner.__name__} has no {self.name}: use a class of message_class()")
        value = self._work(binding)
        type.__setattr__(binding.cls, self.name, value)
        return value


class MessageMeta(type):
    """Makes `Twist(linear=..., angular=...)` work without an `__init__` on the class.

    Decoding makes instances through `type.__call__` directly, which is nearly twice as fast when there is
    no `__init__`. A subclass may have one; it starts from default values.
    """

    _fill: Callable[[object], None]
    _names: frozenset[str]

    def __call__(cls, /, *args: object, **kwargs: object) -> Any:
        self: Any = object.__new__(cls)  # type: ignore[arg-type]
        if cls.__init__ is not object.__init__:  # type: ignore[misc]
            cls._fill(self)
            cls.__init__(self, *args, **kwargs)  # type: ignore[misc]
            return self
        if args:
            cls._set_all(self, args, kwargs)
            return self
        cls._fill(self)
        for name, value in kwargs.items():
            if name not in cls._names:
                raise AttributeError(f"{name!r} is not a field of {cls._describe()}")
            if value is not None:  # as in genpy, None means the default
                setattr(self, name, value)
        return self

    def _set_all(cls, self: Message, args: tuple[object, ...], kwargs: dict[str, object]) -> None:
        slots = cls.__slots__  # type: ignore[attr-defined]
        if kwargs:
            raise TypeError(f"{cls.__name__} takes positional or keyword arguments, not both")
        if len(args) != len(slots):
            raise TypeError(f"{len(args)} arguments given, expected all of {cls._describe()}")
        if any(arg is None for arg in args):
            cls._fill(self)
        else:
            self._connection_header = None
        for name, value in zip(slots, args, strict=True):
            if value is not None:
                setattr(self, name, value)

    def _describe(cls) -> str:
        return f"{cls._type}, which has {', '.join(cls.__slots__) or 'no fields'}"  # type: ignore[attr-defined]


def _only_a_base(*_: object) -> NoReturn:
    raise TypeError("Message is only a base: use a class of message_class() or msgdefs")


class Message(metaclass=MessageMeta):
    """Base of all messages. Classes come from `message_class`, `define` and msgdefs, not from here.

    Construct with all fields by position, or any by keyword; the others get defaults: zeros, empty strings,
    default messages, lists for arrays of messages, strings and times, writable numpy arrays for arrays of
    numbers. Lists may be assigned to arrays, bytes to uint8[] and char[]. Fields are plain
    attributes. For a field named like a Python keyword (`in`), use getattr and setattr, or `in_`.

    Comparing treats lists, tuples and arrays with equal elements as equal; NaN differs from itself, as in
    Python. Messages are mutable and not hashable.

    Attributes:
        _type: "package/Type".
        _md5sum: The checksum that peers compare.
        _full_text: Definition with those of all types used.
        _slot_types: Field types, in the order of `__slots__`.
        _has_header: Its first field is `Header header`.
        _spec: The parsed definition.
        _binding: Its library, layout and generated functions. None for a base.
        _encode: The function behind `encode`, generated with its first use.
        _has_views: Arrays of a decoded message refer to the bytes it came from.
        _connection_header: Header fields of the connection it was received on, else None.
    """

    __slots__ = ("_connection_header",)

    _type: ClassVar[str] = ""
    _spec: ClassVar[MessageSpec]
    _has_header: ClassVar[bool] = False
    _binding: ClassVar[Binding | None] = None
    _names: ClassVar[frozenset[str]] = frozenset()
    _md5sum: ClassVar[str]
    _full_text: ClassVar[str]
    _slot_types: ClassVar[Sequence[str]]
    _has_views: ClassVar[bool]

    _connection_header: dict[str, str] | None

    if TYPE_CHECKING:  # at run time the metaclass does this

        def __init__(self, *args: Any, **kwargs: Any) -> None: ...

        def _fill(self) -> None: ...
        def _encode(self) -> bytes: ...
        @classmethod
        def _decode(cls, data: Octets, start: int, end: int) -> Self: ...

    else:
        _fill = _encode = _decode = _only_a_base

    def _get_types(self) -> list[str]:
        return list(self._slot_types)

    def serialize(self, buff: Writer[bytes]) -> None:
        """Write the encoded message to `buff`, an object with `write(bytes)`.

        Raises:
            CodecError: A value does not fit its field.
        """
        buff.write(self._encode())

    def deserialize(self, str: Octets) -> Self:
        """Set all fields from encoded bytes and return this message. The argument's name is genpy's.

        Raises:
            CodecError: Bytes and definition disagree; this message is unchanged.
        """
        data = bytes(str)
        new = type(self)._decode(data, 0, len(data))
        for name in self.__slots__:
            setattr(self, name, getattr(new, name))
        return self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message):
            return NotImplemented
        if self._type != other._type or list(self.__slots__) != list(other.__slots__):
            return False
        missing = object()
        return all(
            _equal(getattr(self, name, missing), getattr(other, name, missing)) for name in self.__slots__
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return self.__str__()

    def __str__(self) -> str:
        from rosproto.codec.text import strify_message

        return strify_message(self)

    def __getstate__(self) -> list[object]:
        return [getattr(self, name) for name in self.__slots__]

    def __setstate__(self, state: Sequence[object]) -> None:
        for name, value in zip(self.__slots__, state, strict=True):
            setattr(self, name, value)
        self._connection_header = None

    def __reduce__(self) -> tuple[object, ...]:
        from rosproto.codec.classes import pickled

        return pickled(self)

    def __copy__(self) -> Self:
        new = object.__new__(type(self))
        for name in (*self.__slots__, "_connection_header"):
            if hasattr(self, name):
                setattr(new, name, getattr(self, name))
        return new

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """A copy that shares nothing; its arrays are writable."""
        import copy

        new = memo[id(self)] = object.__new__(type(self))
        for name in (*self.__slots__, "_connection_header"):
            if hasattr(self, name):
                setattr(new, name, copy.deepcopy(getattr(self, name), memo))
        return new


for lazy in (
    _Lazy("_md5sum", lambda b: b.library.md5sum(b.spec.name, kind="msg")),
    _Lazy("_full_text", lambda b: b.library.full_text(b.spec.name, kind="msg")),
    _Lazy("_slot_types", lambda b: [str(field.type) for field in b.spec.fields]),
    _Lazy("_has_views", lambda b: b.has_views),
):
    setattr(Message, lazy.name, lazy)


if TYPE_CHECKING:

    class _DynamicMeta(MessageMeta):
        def __getattr__(cls, name: str) -> Any: ...

    class DynamicMessage(Message, metaclass=_DynamicMeta):
        """A message for type checkers: any field or constant is allowed."""

        def __getattr__(self, name: str) -> Any: ...
        def __setattr__(self, name: str, value: Any) -> None: ...

else:
    DynamicMessage = Message


def _equal(ours: object, theirs: object) -> bool:
    """Equality of field values; arrays, lists, tuples and bytes compare by element."""
    if ours is theirs and not hasattr(ours, "dtype"):
        return ours == theirs if isinstance(ours, (float, list, tuple, Message)) else True
    if hasattr(ours, "dtype") or hasattr(theirs, "dtype"):
        return _equal_arrays(ours, theirs)
    if isinstance(ours, (list, tuple)) and isinstance(theirs, (list, tuple)):
        return len(ours) == len(theirs) and all(map(_equal, ours, theirs))
    return bool(ours == theirs)


def _equal_arrays(ours: object, theirs: object) -> bool:
    import numpy as np

    def flat(value: object) -> NDArray[np.generic]:
        if isinstance(value, (bytes, bytearray, memoryview)):
            return np.frombuffer(bytes(value), "u1")
        return np.asarray(value).reshape(-1)

    try:
        return bool(np.array_equal(flat(ours), flat(theirs)))
    except (ValueError, TypeError):
        return False


class AnyMsg(Message):
    """A message of any type, not decoded, for relays, recorders and statistics.

    Attributes:
        _buff: The encoded message.
    """

    __slots__ = ("_buff",)
    _slot_types = ()
    _type = "*"
    _md5sum = "*"
    _full_text = ""
    _has_views = True  # the bytes given are kept

    _buff: bytes

    def _fill(self) -> None:
        self._buff = b""
        self._connection_header = None

    def _encode(self) -> bytes:
        return bytes(self._buff)

    @classmethod
    def _decode(cls, data: Octets, start: int, end: int) -> Self:
        message = object.__new__(cls)
        message._buff = bytes(data[start:end])
        message._connection_header = None
        return message

    _names = frozenset({"_buff"})

    def __reduce__(self) -> tuple[object, ...]:
        return AnyMsg, (self._buff,)

    def __str__(self) -> str:
        return f"<{len(self._buff)} bytes of an unknown type>"


class ServiceType:
    """Base of all service classes: a namespace for the request and response classes.

    Attributes:
        _type: "package/Type".
        _md5sum: The checksum of request and response that peers compare.
        Request, _request_class: Class of the request, "package/TypeRequest".
        Response, _response_class: Class of the response.
    """

    _type: ClassVar[str] = ""
    _md5sum: ClassVar[str] = ""
    Request: ClassVar[type[DynamicMessage]]
    Response: ClassVar[type[DynamicMessage]]
    _request_class: ClassVar[type[DynamicMessage]]
    _response_class: ClassVar[type[DynamicMessage]]
