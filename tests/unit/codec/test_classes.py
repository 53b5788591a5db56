"""Classes by name: identity, caches, services, constants, odd field names."""

from __future__ import annotations

import copy
import pickle

import pytest

from rosproto.codec import AnyMsg, Message, decode, define, encode, message_class, service_class
from rosproto.errors import CodecError, DefinitionError
from rosproto.msg import DefinitionLibrary, Field, FieldType, MessageSpec, bundled
from rosproto.msg.parser import parse_message

SEPARATOR = "\n" + "=" * 80 + "\nMSG: "


def test_the_same_name_gives_the_same_class() -> None:
    """Classes are made once, so `isinstance` and `is` work across callers."""
    twist = message_class("geometry_msgs/Twist")
    assert message_class("geometry_msgs/Twist") is twist
    assert type(twist().linear) is message_class("geometry_msgs/Vector3")
    assert message_class("Header") is message_class("std_msgs/Header")


def test_class_attributes_are_genpys() -> None:
    """The names that rospy's tools read are there, with the values genpy has."""
    twist = message_class("geometry_msgs/Twist")
    assert twist._type == "geometry_msgs/Twist"
    assert twist._md5sum == "9f195f881246fdfa2798d1d3eebca84a"
    assert list(twist.__slots__) == ["linear", "angular"]
    assert twist._slot_types == ["geometry_msgs/Vector3", "geometry_msgs/Vector3"]
    assert "MSG: geometry_msgs/Vector3" in twist._full_text
    assert not twist._has_header
    assert message_class("nav_msgs/Odometry")._has_header
    assert twist()._connection_header is None


def test_services_have_request_and_response() -> None:
    """All of genpy's names lead to the same two classes."""
    set_bool = service_class("std_srvs/SetBool")
    assert set_bool._md5sum == "09fb03525b03e7ea1fd3992bafd87e16"
    assert set_bool.Request is set_bool._request_class
    assert set_bool.Response._type == "std_srvs/SetBoolResponse"
    assert encode(set_bool.Request(data=True)) == b"\x01"
    assert set_bool is service_class("std_srvs/SetBool")


def test_constants_are_class_attributes() -> None:
    """Of every type a constant can have."""
    cls = define("a/B", "int8 LOW=-5\nfloat64 HALF=0.5\nstring TEXT=a # b\nbool YES=True\nint8 x")
    assert (cls.LOW, cls.HALF, cls.TEXT, cls.YES) == (-5, 0.5, "a # b", True)  # type: ignore[attr-defined]


@pytest.mark.promise("Comments hold any bytes, and fields may have")
def test_a_field_may_be_named_like_a_python_keyword() -> None:
    """woosh_msgs/NavMode has a field `in`; it is reached with getattr, `**{}` and as `in_`."""
    cls = define("a/B", "int8 in\nstring class\nuint16[] import\ntime None\nfloat32 serialize")
    message = cls(**{"in": 5, "class": "x", "import": [1, 2]})
    back = decode(cls, encode(message))
    assert getattr(back, "in") == 5
    assert getattr(back, "class") == "x"
    assert back.in_ == 5  # type: ignore[attr-defined]  # genpy's name for it
    assert list(getattr(back, "import")) == [1, 2]
    assert list(cls.__slots__) == ["in", "class", "import", "None", "serialize"]


def test_a_field_named_self_has_genpys_name_as_well() -> None:
    """genpy calls it `self_`, as programs made for rospy do."""
    cls = define("pkg/Own", "int8 self\n")
    assert cls(self_=3).self == cls(self=3).self_ == decode(cls, encode(cls(3))).self_ == 3


def test_a_class_can_be_made_of_a_parsed_definition() -> None:
    """Also when the library does not hold it; types it uses come from the library."""
    spec = MessageSpec("x/Y", (Field("at", FieldType("geometry_msgs/Point")),), (), "geometry_msgs/Point at")
    cls = message_class(spec)
    assert encode(cls(at=message_class("geometry_msgs/Point")(x=1.0)))[:8] == b"\0\0\0\0\0\0\xf0?"
    with pytest.raises(DefinitionError):
        bundled().message("x/Y")


@pytest.mark.promise(
    "Nothing that is received is evaluated", "only validated identifiers and numbers enter the generated code"
)
@pytest.mark.parametrize("name", ["a b", "x;y", "", "_x", "a.b", "é", "x\n", "__class__", "x=1"])
def test_a_field_name_that_is_no_identifier_never_reaches_the_generator(name: str) -> None:
    """Definitions made by hand are checked like parsed ones."""
    spec = MessageSpec("x/Y", (Field(name, FieldType("int8")),), (), "")
    with pytest.raises(DefinitionError):
        message_class(spec)


def test_define_makes_a_class_from_a_full_text() -> None:
    """The same text gives the same class; an incomplete one is refused at once."""
    text = "Header header\nQ[] qs" + SEPARATOR + "std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id"
    whole = text + SEPARATOR + "a/Q\nint8 v"
    assert define("a/B", whole) is define("a/B", whole)
    with pytest.raises(DefinitionError, match="a/Q"):
        define("a/B", text)


def test_a_recursive_definition_is_refused() -> None:
    """It has no end on the wire."""
    with pytest.raises(DefinitionError):
        define("a/B", "C c" + SEPARATOR + "a/C\nB[] b" + SEPARATOR + "a/B\nC c")


def test_a_definition_that_doubles_itself_is_refused() -> None:
    """Thirty types of two fields each would be 2**30 values: a nesting bomb."""
    parts = [f"T{i + 1} a\nT{i + 1} b" + SEPARATOR + f"a/T{i + 1}\n" for i in range(30)]
    with pytest.raises(DefinitionError):
        define("a/T0", "".join(parts) + "int8 x")


def nested(depth: int, kind: str) -> str:
    parts = "".join(f"T{i}{kind} a" + SEPARATOR + f"a/T{i}\n" for i in range(1, depth + 1))
    return parts + "float64 x\nstring y"


@pytest.mark.parametrize("kind", ["", "[]"])
@pytest.mark.parametrize("value_style", ["numpy", "rospy"])
def test_sixty_four_messages_inside_one_another(kind: str, value_style: str) -> None:
    """Encoded, decoded, compared, shown, copied, pickled; one more is refused, of a peer and of one's own."""
    cls = define("a/T0", nested(64, kind), value_style=value_style)
    octets = (b"\1\0\0\0" if kind else b"") * 64 + b"\0" * 8 + b"\1\0\0\0" + b"!"
    message = decode(cls, octets)
    assert encode(message) == octets
    assert "!" in str(message)
    assert message == copy.deepcopy(message) == pickle.loads(pickle.dumps(message)) == decode(cls, octets)
    with pytest.raises(CodecError, match=r"\.y: a string of 1 bytes"):
        decode(cls, octets[:-1])
    with pytest.raises(DefinitionError, match="nesting is 65, at most 64"):
        define("a/T0", nested(65, kind))
    own = DefinitionLibrary()
    for i, body in enumerate(nested(65, kind).split(SEPARATOR)):
        own.add(parse_message(body.partition("\n")[2] if i else body, f"a/T{i}"))
    assert message_class("a/T1", own)().__slots__ == ["a"]
    with pytest.raises(DefinitionError, match="more than 64 messages inside one another"):
        message_class("a/T0", own)()


def test_two_libraries_have_two_classes() -> None:
    """A fork may give a type another meaning."""
    library = bundled().fork()
    library.add(MessageSpec("std_msgs/Bool", (Field("data", FieldType("uint16")),), (), "uint16 data"))
    ours = message_class("std_msgs/Bool", library)
    assert ours is not message_class("std_msgs/Bool")
    assert encode(ours(data=300)) == b"\x2c\x01"


def test_any_message_passes_bytes_through() -> None:
    """AnyMsg matches every type and changes nothing."""
    message = decode(AnyMsg, b"abc")
    assert (message._type, message._md5sum, message._buff) == ("*", "*", b"abc")
    assert encode(message) == b"abc"


def test_the_base_class_is_not_a_message() -> None:
    """It says where classes come from."""
    with pytest.raises(TypeError, match="message_class"):
        Message()
    with pytest.raises(TypeError, match="message is expected"):
        encode("text")  # type: ignore[arg-type]


def test_a_subclass_may_have_its_own_init() -> None:
    """It starts from default values, and encodes like its base."""

    class Forward(message_class("geometry_msgs/Twist")):  # type: ignore[misc]
        def __init__(self, speed: float) -> None:
            self.linear.x = speed

    assert encode(Forward(2.0)) == encode(message_class("geometry_msgs/Twist")(linear=Forward(2.0).linear))


def test_the_former_name_of_value_style_works_with_a_warning():
    import rosproto.codec as codec

    with pytest.warns(DeprecationWarning, match="ValueStyle"):
        assert codec.Flavour is codec.ValueStyle
    text = "uint8[] data"
    for make in (
        lambda **style: codec.message_class("sensor_msgs/Image", **style),
        lambda **style: codec.service_class("std_srvs/SetBool", **style),
        lambda **style: codec.define("my_msgs/Data", text, **style),
    ):
        with pytest.warns(DeprecationWarning, match="value_style="):
            made = make(flavour="rospy")
        assert made is make(value_style="rospy")
        assert made is not make()
