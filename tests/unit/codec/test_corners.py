"""What seldom happens: odd objects as values, bounds of what is remembered, definitions that nobody writes."""

from __future__ import annotations

import array
import copy
import gc
import pickle
import threading
import weakref
from typing import Any

import numpy as np
import pytest

from rosproto.codec import (
    AnyMsg,
    Message,
    ValueStyle,
    decode,
    decoder,
    define,
    encode,
    encode_parts,
    encoder,
    generated_source,
    message_class,
    strify_message,
)
from rosproto.codec.dicts import from_dict, to_dict
from rosproto.codec.layout import resolve
from rosproto.codec.reference import decode_layout, encode_layout
from rosproto.codec.value_style import value_style_named
from rosproto.errors import CodecError, DefinitionError
from rosproto.msg import Field, FieldType, MessageSpec, bundled
from rosproto.time import Time

SEPARATOR = "\n" + "=" * 80 + "\nMSG: "
NUMBERS = define("a/Corner", "float32[] f\nuint8[] u\nbool[] b\nint16[] s\nfloat64[3] d\nfloat64[200] big")


class Interface:
    """An array as another library hands it out: no buffer, but numpy's interface."""

    def __init__(self, values: Any) -> None:
        self.values = values
        self.__array_interface__ = values.__array_interface__


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("f", Interface(np.array([1.5, 2.5], "f4")), [1.5, 2.5]),
        ("f", Interface(np.array([1, 2], "i8")), [1.0, 2.0]),
        ("s", np.array([]), []),
        ("s", np.array([], dtype=object), []),
        ("s", array.array("h", [-1, 2]), [-1, 2]),
        ("s", range(3), [0, 1, 2]),
        ("s", (x for x in (4, 5)), [4, 5]),
        ("s", np.array([[1, 2], [3, 4]]), [1, 2, 3, 4]),
        ("b", np.array([0, 3, 0], "i4"), [False, True, False]),
        ("u", memoryview(b"abc"), [97, 98, 99]),
        ("big", list(range(200)), [float(x) for x in range(200)]),
        ("big", np.arange(200.0), [float(x) for x in range(200)]),
        ("big", np.arange(200, dtype="i8"), [float(x) for x in range(200)]),
        ("d", np.arange(3, dtype=">f8"), [0.0, 1.0, 2.0]),
    ],
)
def test_what_holds_numbers_is_taken(field: str, value: Any, expected: list[Any]) -> None:
    """Other dtypes, other byte orders, other libraries' arrays, lists, and whatever can be iterated once."""
    message = NUMBERS()
    setattr(message, field, value)
    if not hasattr(value, "gi_frame"):
        assert getattr(decode(NUMBERS, b"".join(encode_parts(message))), field).tolist() == expected
    assert getattr(decode(NUMBERS, encode(message)), field).tolist() == expected


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("f", np.float64(3), "Corner.f: .*sequence"),
        ("f", np.array(3.0), "Corner.f: .*sequence"),
        ("f", 3.0, "Corner.f: .*sequence"),
        ("f", {1.0: 2}, "Corner.f: .*sequence"),
        ("f", np.array(["a"]), r"Corner.f\[0\]: float32 expected"),
        ("s", np.array([1.5]), r"Corner.s\[0\]: "),
        ("s", [70000], r"Corner.s\[0\]: .*-32768.*32767"),
        ("s", b"ab", "Corner.s: .*sequence"),
        ("d", [1.0], "Corner.d: 3 elements expected, not 1"),
        ("big", np.zeros(199), "Corner.big: 200 elements expected, not 199"),
        ("big", [0.0] * 201, "Corner.big: 200 elements expected, not 201"),
    ],
)
def test_what_holds_no_such_numbers_is_refused(field: str, value: Any, words: str) -> None:
    """The field is named, and what was expected."""
    message = NUMBERS()
    setattr(message, field, value)
    for work in (encode, encode_parts):
        with pytest.raises(CodecError, match=words):
            work(message)


def test_messages_where_lists_of_them_are_meant() -> None:
    """A tuple is a list; an iterator is taken too; text, bytes, a dict and a single message are not."""
    cls = define("a/Lists", "P[] p\nstring[2] s\ntime[] t" + SEPARATOR + "a/P\nint8 x")
    p = type(cls())._binding.class_for("a/P")  # type: ignore[union-attr]
    message = cls(p=(p(x=1), p(x=2)), s=("a", "b"), t=(Time(1, 2),))
    expected = encode(cls(p=[p(x=1), p(x=2)], s=["a", "b"], t=[Time(1, 2)]))
    assert encode(message) == expected
    message.p = iter([p(x=1), p(x=2)])
    assert encode(message) == expected
    for wrong in ("ab", b"ab", {1: 2}, None, 5, p(x=1), {"x": 1}):
        message.p = wrong
        with pytest.raises(CodecError, match=r"a/Lists.p: "):
            encode(message)
    message.p = []
    message.s = ["one"]
    with pytest.raises(CodecError, match=r"a/Lists.s: 2 elements expected, not 1"):
        encode(message)
    for wrong in ({"x": 1}, 5, Time(1)):
        message.s, message.p = ["a", "b"], [wrong]
        with pytest.raises(CodecError, match=r"a/Lists.p\[0\]"):
            encode(message)


def test_a_definition_whose_elements_have_no_bytes() -> None:
    """Such arrays are decoded by the reference codec, from whole buffers and from parts of them."""
    cls = define("a/Sparse", "E[] e\nuint8[] u\nstring s" + SEPARATOR + "a/E\n")
    element = type(cls())._binding.class_for("a/E")  # type: ignore[union-attr]
    message = cls(e=[element(), element()], u=b"ab", s="x")
    data = encode(message)
    assert data == b"\2\0\0\0" + b"\2\0\0\0ab" + b"\1\0\0\0x"
    for back in (
        decode(cls, data),
        decode(cls, bytearray(data)),
        decoder(cls)(b"!" + data, 1, 1 + len(data)),
    ):
        assert back == message
        assert not back.u.flags.writeable
    assert not cls._has_views
    for wrong in (data[:-1], data + b"!"):
        with pytest.raises(CodecError):
            decode(cls, wrong)


def test_what_is_no_message_cannot_be_encoded() -> None:
    """TypeError says what was given; an unfinished message keeps its own error."""
    with pytest.raises(TypeError, match="a message is expected, not str 'text'"):
        encode("text")  # type: ignore[arg-type]
    with pytest.raises(AttributeError, match="_buff"):
        encode(AnyMsg.__new__(AnyMsg))
    for work in (lambda: encode(Message.__new__(Message)), lambda: Message._decode(b"", 0, 0),
                 lambda: decode(Message, b""), Message):  # fmt: skip
        with pytest.raises(TypeError, match="only a base"):
            work()
    for name in ("_md5sum", "_full_text", "_slot_types", "_has_views"):
        with pytest.raises(AttributeError, match=f"Message has no {name}"):
            getattr(Message, name)


def test_any_message_in_every_way() -> None:
    """Bytes of an unknown type: encoded in whole and in parts, decoded, constructed, shown, copied."""
    message = decode(AnyMsg, b"abc")
    assert (encode(message), encode_parts(message), message._buff) == (b"abc", [b"abc"], b"abc")
    assert decode(AnyMsg, bytearray(b"abc")) == message == AnyMsg(b"abc") == copy.deepcopy(message)
    assert AnyMsg()._buff == b""
    assert str(message) == "<3 bytes of an unknown type>"
    with pytest.raises(TypeError):
        decode(AnyMsg, 3)  # type: ignore[arg-type]


def test_parts_of_small_and_of_no_bytes() -> None:
    """There is always a part, and small ones are joined."""
    assert encode_parts(message_class("std_msgs/Empty")()) == [b""]
    message = NUMBERS(f=np.zeros(5000, "f4"), u=bytearray(5000), s=[1, 2])
    parts = encode_parts(message)
    assert b"".join(parts) == encode(message)
    assert [len(part) >= 4096 for part in parts] == [False, True, False, True, False]
    message.u = np.zeros(10000, "u1")[::2]
    assert b"".join(encode_parts(message)) == encode(message)


def test_an_unfinished_message_can_be_copied_and_shown() -> None:
    """As one made by `cls.__new__(cls)` before its fields are set."""
    cls = message_class("geometry_msgs/Point32")
    blank = cls.__new__(cls)
    blank.x = 1.0
    for twin in (copy.copy(blank), copy.deepcopy(blank)):
        assert twin.x == 1.0
        assert not hasattr(twin, "y")
        assert twin == blank
    assert blank != cls(x=1.0)
    assert str(blank).startswith("x: 1.0\ny: None")
    with pytest.raises(CodecError, match=r"geometry_msgs/Point32\.y: has no value"):
        encode(blank)


def test_equality_of_arrays_with_what_is_none() -> None:
    """Bytes, lists and arrays of equal elements are equal; what has other shapes or kinds is not."""
    a = NUMBERS(u=b"ab", f=[1.0])
    assert a == NUMBERS(u=np.array([97, 98], "u1"), f=np.array([1.0], "f4"))
    assert a == NUMBERS(u=bytearray(b"ab"), f=(1.0,))
    for other in (np.array([1, 2, 3], "u1"), [97], "ab", None, [[1], [1, 2]], 97):
        changed = NUMBERS(f=[1.0])
        changed.u = other
        with_array = NUMBERS(f=[1.0], u=np.array([97, 98], "u1"))
        assert with_array != changed
        assert changed != with_array
    assert a != "text"
    assert a.__eq__("text") is NotImplemented


def test_value_styles_by_name() -> None:
    """An unknown name is an error that lists the known ones; one's own is found by pickles."""
    with pytest.raises(ValueError, match=r"value style .nump. is unknown.*numpy.*rospy"):
        message_class("std_msgs/Bool", value_style="nump")
    own = ValueStyle("corner", views=False)
    assert repr(own) == "ValueStyle('corner')"
    assert value_style_named(own) is value_style_named("corner") is own


def test_definitions_by_text_on_top_of_a_library() -> None:
    """With `base`, types that the text lacks are found there, and the class is kept by that library alone."""
    text = "std_msgs/Bool flag"
    with pytest.raises(DefinitionError):
        define("a/Onto", text)
    cls = define("a/Onto", text, base=bundled())
    assert cls().flag.data is False
    assert define("a/Onto", text, base=bundled()) is not cls


def test_only_the_last_definitions_are_kept() -> None:
    """A peer that sends new definitions for ever takes no memory for ever."""
    first = define("a/Kept0", "int8 x")
    assert define("a/Kept0", "int8 x") is first
    for index in range(1, 258):
        define(f"a/BoundedCache{index}", "int8 x")
    assert define("a/Kept257", "int8 x") is define("a/Kept257", "int8 x")
    assert define("a/Kept0", "int8 x") is not first


def test_structs_kept_for_all_types_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """When there are too many they are made again, and everything works."""
    monkeypatch.setattr(generated_source, "STRUCTS_KEPT", 2)
    for index in range(1, 8):
        cls = define(f"a/Structs{index}", f"int8[{index}] a\nint32 x\n" + "float32 y\n" * (index % 2))
        assert decode(cls, encode(cls(x=index))).x == index
        assert len(generated_source.shared_methods) <= 2


def test_long_structs_are_not_kept_for_all_types(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few types share one, and it takes memory for each of its characters."""
    monkeypatch.setattr(generated_source, "shared_methods", {})
    cls = define("a/LongStruct", "".join(f"int8 a{i}\nint16 b{i}\n" for i in range(150)))
    assert decode(cls, encode(cls(b149=7))).b149 == 7
    assert (
        max(map(len, (form for form, _ in generated_source.shared_methods)), default=0)
        <= generated_source.MAX_SHARED_CHARACTERS
    )


@pytest.mark.parametrize("fields", [4, 30])
def test_elements_of_numbers_and_times_small_and_large(fields: int) -> None:
    """Four in a turn, or one after the other: the same values, whatever follows."""
    numbers = "".join(f"float64 x{i}\n" for i in range(fields))
    cls = define(f"a/Runs{fields}", f"E[] e\nuint8 z{SEPARATOR}a/E\ntime t\n{numbers}")
    element = type(cls())._binding.class_for("a/E")  # type: ignore[union-attr]
    for count in (0, 1, 4, 7):
        message = cls(z=9, e=[element(t=Time(i, 1), x0=i, **{f"x{fields - 1}": -i}) for i in range(count)])
        assert decode(cls, encode(message)) == message


@pytest.mark.slow
def test_classes_of_long_texts_are_collected_in_time() -> None:
    """They are in cycles, and so few objects that the collector would let hundreds of megabytes lie."""
    collected: list[int] = []
    gone: list[weakref.ref[type]] = []

    def note(phase: str, info: dict[str, int]) -> None:
        if phase == "stop":
            collected.append(sum(each() is not None for each in gone))

    gc.disable()
    gc.callbacks.append(note)
    try:
        for index in range(50):
            gone.append(weakref.ref(define(f"a/Long{index}", "int8 x\n# " + "x" * 500_000, base=None)))
    finally:
        gc.callbacks.remove(note)
        gc.enable()
    # After each 4 million characters, which are 9 texts; of 2 million the classes are kept.
    assert 4 <= len(collected) <= 6
    assert max(collected) <= 5


class OneType:
    """A source of definitions that is not a library, and checks nothing."""

    def __init__(self, **types: list[tuple[str, str]]) -> None:
        self.types = types

    def message(self, name: str) -> MessageSpec:
        fields = tuple(Field(field, FieldType(kind)) for kind, field in self.types[name.partition("/")[2]])
        return MessageSpec(name, fields, (), "")


def test_layouts_of_definitions_that_no_parser_made() -> None:
    """What the parser refuses is refused here once more: names become part of generated source."""
    given = OneType(
        Loop=[("a/Loop", "again")],
        Twice=[("int8", "x"), ("int8", "x")],
        Name=[("int8", "x = 1")],
        **{f"Deep{i}": [(f"a/Deep{i + 1}", "x")] for i in range(70)},
    )
    for name, words in [
        ("Loop", "a/Loop contains a/Loop: a message cannot contain itself"),
        ("Twice", "a/Twice: field x is defined twice"),
        ("Name", "a/Name: field name 'x = 1' is not a letter followed by"),
        ("Deep0", "a/Deep0: more than 64 messages inside one another"),
    ]:
        with pytest.raises(DefinitionError, match=words):
            resolve(given.message(f"a/{name}"), given)


def test_the_reference_codec_by_definition() -> None:
    """Bytes to plain values and back, without a class."""
    spec = bundled().message("geometry_msgs/PointStamped")
    layout = resolve(spec, bundled())
    value = {
        "header": {"seq": 1, "stamp": (2, 3), "frame_id": "map"},
        "point": {"x": 1.0, "y": 2.0, "z": 3.0},
    }
    data = encode_layout(layout, value)
    assert data == encode(from_dict(message_class(spec.name), {"header": {"seq": 1, "frame_id": "map",
        "stamp": {"secs": 2, "nsecs": 3}}, "point": [1.0, 2.0, 3.0]}))  # fmt: skip
    assert decode_layout(layout, data, 0, len(data)) == value
    assert decode_layout(layout, b"?" + data + b"?", 1, len(data) + 1) == value
    with pytest.raises(CodecError, match="header: a std_msgs/Header is expected, not int 5"):
        encode_layout(layout, {**value, "header": 5})


def test_a_list_too_long_for_its_count() -> None:
    """The wire has 32 bits for it."""

    class Endless(list[int]):
        def __len__(self) -> int:
            return 1 << 32

    layout = resolve(bundled().message("std_msgs/Int8MultiArray"), bundled())
    value = {"layout": {"dim": [], "data_offset": 0}, "data": Endless()}
    with pytest.raises(CodecError, match="data: 4294967296 elements, at most 4294967295 fit"):
        encode_layout(layout, value)


def test_a_message_of_plain_values() -> None:
    """Times of messages are dicts; so are those of any class with secs and nsecs."""
    message = message_class("std_msgs/Header")(seq=1, stamp=Time(2, 3))
    assert to_dict(message) == {"seq": 1, "stamp": {"secs": 2, "nsecs": 3}, "frame_id": ""}
    assert to_dict(NUMBERS(u=bytearray(b"ab")))["u"] == [97, 98]
    message.frame_id = float("nan")
    assert to_dict(message, finite=True)["frame_id"] is None


def test_numbers_of_a_fixed_width_in_text() -> None:
    """As `rostopic echo --precision`: digits behind the point are cut, those before it are not."""
    twist = message_class("geometry_msgs/Vector3")(x=1.23456, y=-123456.7, z=2)
    assert strify_message(twist, width=3) == "x: 1.2\ny: -123456\nz:   2"
    values = NUMBERS(f=[0.5, 12.25], d=[1, 2, 3])
    values.b = [True, False]
    shown = strify_message(values, width=4)
    assert "f: [0.50, 12.2]" in shown
    assert "b: [True, False]" in shown


def test_two_threads_make_one_class() -> None:
    """The second waits for the first, and gets its class."""
    library = bundled().fork()
    found: list[Any] = []
    barrier = threading.Barrier(8)

    def make() -> None:
        barrier.wait(10)
        found.append(message_class("nav_msgs/Odometry", library))

    threads = [threading.Thread(target=make) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)
    assert len(found) == 8
    assert len(set(map(id, found))) == 1


def test_defaults_of_fixed_arrays_in_both_value_styles() -> None:
    """Elements are objects of their own; numbers are zeros, as arrays or in genpy's kinds."""
    text = (
        "time[2] t\nduration[1] d\nP[2] p\nuint8[3] u\nfloat64[3] f\nint8[2] i\nbool[2] b"
        + SEPARATOR
        + "a/P\nint8 x"
    )
    ours, genpys = (define("a/Defaults", text, value_style=value_style) for value_style in ("numpy", "rospy"))
    for cls in (ours, genpys):
        message = cls()
        assert message.t == [Time(), Time()]
        assert message.t[0] is not message.t[1]
        assert message.p[0] is not message.p[1]
        assert decode(cls, encode(message)) == message
    message = genpys()
    assert (message.u, message.f, message.i, message.b) == (b"\0\0\0", [0.0] * 3, [0, 0], [False, False])
    message.u, message.f, message.i = [1, 2, 3], (1.0, 2.0, 3.0), np.array([4, 5], "i1")
    back = decode(genpys, encode(message))
    assert (back.u, back.f, back.i, back.b) == (b"\1\2\3", (1.0, 2.0, 3.0), (4, 5), [False, False])
    for name, wrong in (("u", b"\1\2"), ("u", b"\1\2\3\4"), ("f", [1.0])):
        changed = copy.copy(message)
        setattr(changed, name, wrong)
        with pytest.raises(CodecError, match=rf"a/Defaults\.{name}: 3 elements expected"):
            encode(changed)


def test_sparse_definitions_hold_all_kinds_of_values() -> None:
    """What the reference codec decodes has the values that the generated code would give."""
    text = (
        "E[] e\ntime t\nduration[] d\nuint8[] u\nint16[] i\nbool[] b\nI n"
        + SEPARATOR
        + "a/E\n"
        + SEPARATOR
        + "a/I\nint8 x"
    )
    for value_style in ("numpy", "rospy"):
        cls = define("a/SparseAll", text, value_style=value_style)
        message = cls(t=Time(1, 2), u=b"ab", i=[1, -1], b=[True, False])
        message.d = [type(message.t - message.t)(3, 4)]
        back = decode(cls, encode(message))
        assert back == message
        assert back._connection_header is None
        assert (list(back.u), list(back.i), list(back.b)) == ([97, 98], [1, -1], [True, False])


def test_errors_beside_values_that_are_right() -> None:
    """The wrong one is named, whatever kinds the others are of."""
    twist = message_class("geometry_msgs/Twist")()
    twist.linear = {"x": 1.0}
    with pytest.raises(CodecError, match=r"Twist\.linear: a geometry_msgs/Vector3 is expected, not dict"):
        encode(twist)
    message = NUMBERS(u=memoryview(b"ab"), b=np.array([True]), s=np.array([[1, 2]]), f=np.array([], "f8"))
    message.d = [1.0, 2.0, "3"]
    with pytest.raises(CodecError, match=r"a/Corner\.d\[2\]: float64 expected, not str '3'"):
        encode(message)
    floats = NUMBERS()
    for wrong in (np.array([1.5]), np.array(["false"]), np.array([None])):
        floats.b = wrong
        with pytest.raises(CodecError, match=r"a/Corner\.b\[0\]: "):
            encode(floats)


def test_two_large_arrays_side_by_side() -> None:
    """No empty part lies between them."""
    cls = define("a/Large", "uint8[5000] a\nuint8[5000] b")
    assert [len(part) for part in encode_parts(cls())] == [5000, 5000]


def test_a_class_of_a_definition_that_the_library_has() -> None:
    """The library's own class, whether it was made before or not."""
    library = bundled().fork()
    spec = library.message("std_msgs/Bool")
    assert (
        message_class(spec, library)
        is message_class("std_msgs/Bool", library)
        is message_class(spec, library)
    )
    assert message_class(spec, library)()._get_types() == ["bool"]


def test_functions_of_any_message() -> None:
    """Relays ask for them as for those of any other class."""
    message = decoder(AnyMsg)(b"-abc-", 1, 4)
    assert encoder(AnyMsg)(message) == b"abc"
    assert pickle.loads(pickle.dumps(message)) == message


def test_arrays_of_messages_that_hold_arrays() -> None:
    """Such elements have no size in common, and are read one by one."""
    cls = define("a/Holds", "P[] p\nint8 x" + SEPARATOR + "a/P\nI i\nstring s" + SEPARATOR + "a/I\nint8[] n")
    p, i = (type(cls())._binding.class_for(name) for name in ("a/P", "a/I"))  # type: ignore[union-attr]
    message = cls(p=[p(i=i(n=[1] * k), s="x" * k) for k in range(5)], x=3)
    assert decode(cls, encode(message)) == message


def test_fixed_arrays_of_the_reference_codec_that_end_early() -> None:
    """The element at which the bytes end is named."""
    cls = define("a/Fixed", "E[] e\nint32[3] x\nstring[2] s" + SEPARATOR + "a/E\n")
    data = encode(cls(x=[1, 2, 3], s=["a", "b"]))
    for end in range(len(data)):
        with pytest.raises(CodecError, match=r"a/Fixed"):
            decode(cls, data[:end])


def test_a_class_that_another_thread_has_made_meanwhile_is_taken() -> None:
    library = bundled().fork()
    made = message_class("std_msgs/String", library)

    class Late(dict[Any, Any]):
        """Knows nothing when it is asked first."""

        asked = 0

        def get(self, key: Any, default: Any = None) -> Any:
            self.asked += 1
            return default if self.asked == 1 else super().get(key, default)

    vars(library)["_classes"] = late = Late(vars(library)["_classes"])
    assert message_class("std_msgs/String", library) is made
    assert late.asked == 2
