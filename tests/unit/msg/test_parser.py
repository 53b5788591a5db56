"""The parser reads what genmsg reads and refuses what genmsg refuses (tests/interop/test_genmsg.py compares)."""

from __future__ import annotations

import pytest

from rosproto.errors import DefinitionError, RosError
from rosproto.msg import Constant, Field, FieldType, MessageSpec, parse_action, parse_message, parse_service


def parse(text: str, name: str = "pkg/Type", lenient: bool = False) -> MessageSpec:
    return parse_message(text, name, lenient=lenient)


def constant(text: str, lenient: bool = False) -> Constant:
    (found,) = parse(text, lenient=lenient).constants
    return found


def test_fields_come_in_order_with_resolved_types() -> None:
    """Builtin types stay, others get the package, `Header` is std_msgs/Header."""
    spec = parse("Header header\nPoint[] path\ngeometry_msgs/Pose pose\nfloat64[36] covariance\nstring s\n")
    assert [(f.name, str(f.type)) for f in spec.fields] == [
        ("header", "std_msgs/Header"),
        ("path", "pkg/Point[]"),
        ("pose", "geometry_msgs/Pose"),
        ("covariance", "float64[36]"),
        ("s", "string"),
    ]
    assert spec.package == "pkg"


@pytest.mark.parametrize("text", ["", "\n\n", "# only words\n", "   # indented\n\t\n", "\r\n"])
def test_a_message_may_be_empty(text: str) -> None:
    """Comments and blank lines make no field, and the text is kept as it is."""
    spec = parse(text)
    assert spec.fields == ()
    assert spec.constants == ()
    assert spec.text == text


def test_crlf_line_ends_do_not_matter() -> None:
    """A carriage return before the line feed is white space."""
    spec = parse("int32 a\r\nstring S=x\r\n")
    assert spec.fields == parse("int32 a").fields
    assert spec.constants[0].value == spec.constants[0].text == "x"


def test_a_comment_needs_no_space_before_it() -> None:
    """Everything from `#` on is a comment in a field line, `=` included."""
    assert parse("int32 a#= 3 = 4").fields == (Field("a", FieldType("int32")),)


@pytest.mark.promise("A tab separates nothing in genmsg")
@pytest.mark.parametrize("text", ["int32\ta", "int32 \ta b", "\tint32\ta\n"])
def test_a_tab_is_no_separator_in_a_file(text: str) -> None:
    """genmsg splits at blanks only, so such a file breaks every other ROS tool (wire.md, fact 42)."""
    with pytest.raises(DefinitionError):
        parse(text)


def test_the_error_about_a_tab_says_so() -> None:
    """Nobody sees a TAB in an editor."""
    with pytest.raises(DefinitionError, match="TAB"):
        parse("int32\ta")


@pytest.mark.promise("A tab separates nothing in genmsg")
def test_a_tab_from_a_peer_is_read() -> None:
    """Other generators accept it, and the md5sum is the same (wire.md, fact 42: lenient on input)."""
    spec = parse("int32\ta\nstring\tS=x\tx # y\nuint8\t\tB = 3\n", lenient=True)
    assert spec.fields == parse("int32 a").fields
    assert [(c.name, c.text) for c in spec.constants] == [("S", "x\tx # y"), ("B", "3")]


def test_a_tab_before_or_after_a_blank_is_white_space() -> None:
    """genmsg strips each word, so only a TAB without a blank is a problem."""
    assert parse("\tint32 \ta\t").fields == parse("int32 a").fields


@pytest.mark.parametrize(
    "line",
    [
        "int32",
        "int32 a b",
        "int32 a, b",
        "int32 1a",
        "int32 _a",
        "int32 a-b",
        "int32 gr\u00f6sse",
        "int32 a\u0663",
        "int 32[] a",
        "int32[ a",
        "int32[] ] a",
        "int32[]] a",
        "int32[][] a",
        "int32[2][3] a",
        "int32[-1] a",
        "int32[x] a",
        "int32[0x3] a",
        "int32[1 ] a",
        "int32[]x a",
        "[] a",
        "a/b/c d",
        "/Point p",
        "geometry_msgs/ p",
        "geometry_msgs//Point p",
        "1geometry/Point p",
        "Po-int p",
        "\ufeffint32 a",
        f"int32[{'9' * 5000}] a",
    ],
)
def test_illegal_fields_are_refused_with_the_line(line: str) -> None:
    """The error has file and line and says what was expected."""
    with pytest.raises(DefinitionError, match=r"expected|integer") as caught:
        parse_message(f"# first\n{line}\n", "pkg/Type", file="Type.msg")
    assert (caught.value.file, caught.value.line) == ("Type.msg", 2)
    assert str(caught.value).startswith("Type.msg:2: pkg/Type: ")
    assert len(str(caught.value)) < 300


def test_without_a_file_the_line_is_in_the_text() -> None:
    """Texts from the network have lines too."""
    with pytest.raises(DefinitionError, match="pkg/Type, line 2: "):
        parse("int32 a\nint32\n")


def test_a_field_twice_is_refused_at_the_second() -> None:
    """Names of fields are unique; constants may repeat, as genmsg lets them."""
    with pytest.raises(DefinitionError, match="a occurs twice") as caught:
        parse("int32 a\nint8 b\nstring a")
    assert caught.value.line == 3
    assert len(parse("int32 A=1\nint32 A=1").constants) == 2


@pytest.mark.parametrize(
    "name", ["Type", "pkg/", "/Type", "a/b/c", "pkg/Ty-pe", "1/2", "", "pkg/Typ\u00e9", "p/T\n"]
)
def test_names_of_types_are_checked(name: str) -> None:
    """Code is generated from them, so nothing but identifiers passes."""
    for call in (parse_message, parse_service, parse_action):
        with pytest.raises(DefinitionError, match="package/Type"):
            call("", name)


def test_keywords_and_other_names_of_python_are_legal() -> None:
    """woosh_msgs/NavMode has a field `in` (wire.md, fact 43)."""
    spec = parse("uint8 in\nuint8 class\nuint8 None\nuint8 self\nuint8 serialize\n")
    assert [f.name for f in spec.fields] == ["in", "class", "None", "self", "serialize"]


@pytest.mark.promise("Comments hold any bytes, and fields may have")
def test_texts_may_hold_anything_in_comments() -> None:
    """Quotes, back-ticks, other alphabets and bytes that are not UTF-8 (wire.md, fact 43)."""
    text = 'int32 a # `rm` """ \'\'\' \\ \u4e2d\u6587 \udcff\nstring S=\'"""\\\n'
    spec = parse(text)
    assert spec.text == text
    assert spec.constants[0].value == '\'"""\\'


class TestHeader:
    """`Header` is special in one spelling and `header` in one place (wire.md, fact 41)."""

    @pytest.mark.promise("`Header` is `std_msgs/Header` unless it is an array")
    def test_header_is_short_for_std_msgs_anywhere(self) -> None:
        spec = parse("int32 a\nHeader h\n")
        assert spec.fields[1].type.base == "std_msgs/Header"

    def test_an_array_of_header_is_the_package_s_own(self) -> None:
        assert parse("Header[] h").fields[0].type.base == "pkg/Header"
        assert parse("Header[2] h").fields[0].type.base == "pkg/Header"

    @pytest.mark.promise("`Header` is `std_msgs/Header` unless it is an array")
    @pytest.mark.parametrize(
        ("text", "has"),
        [
            ("Header header\nint32 a", True),
            ("std_msgs/Header header", True),
            ("int32 a\nHeader header", False),
            ("Header h", False),
            ("std_msgs/Header[] header", False),
            ("string header", False),
            ("roslib/Header header", False),
            ("", False),
        ],
    )
    def test_only_a_first_field_named_header_is_filled_in(self, text: str, has: bool) -> None:
        assert parse(text).has_header is has


class TestConstants:
    """Literals are kept as written and checked as genmsg checks them (wire.md, fact 40)."""

    @pytest.mark.parametrize(
        ("text", "value", "literal"),
        [
            ("string FOO=a # b", "a # b", "a # b"),
            ("string FOO=", "", ""),
            ("string FOO=#abc", "#abc", "#abc"),
            ("string FOO=  a = b  ", "a = b", "a = b"),
            ("string  FOO  = x", "x", "x"),
            ("string FOO=\u4e2d", "\u4e2d", "\u4e2d"),
            ("int32 X=5", 5, "5"),
            ("int32 X = -5 # minus", -5, "-5"),
            ("  int32   X   =   +5   ", 5, "+5"),
            ("int32 X=007", 7, "007"),
            ("int32 X=1_000", 1000, "1_000"),
            ("float32 X=1.50", 1.5, "1.50"),
            ("float64 X=-1e3", -1000.0, "-1e3"),
            ("float64 X=inf", float("inf"), "inf"),
            ("bool B=True", True, "True"),
            ("bool B=1", True, "1"),
            ("bool B=0", False, "0"),
            ("bool B=False", False, "False"),
            ("bool B=2", True, "2"),
            ("bool B=[]", False, "[]"),
            ("bool B='no'", True, "'no'"),
            ("char C=200", 200, "200"),
            ("byte C=-128", -128, "-128"),
            ("uint64 X=18446744073709551615", 2**64 - 1, "18446744073709551615"),
            ("int64 X=-9223372036854775808", -(2**63), "-9223372036854775808"),
        ],
    )
    def test_values_and_literals(self, text: str, value: object, literal: str) -> None:
        found = constant(text)
        assert (found.value, found.text) == (value, literal)
        assert type(found.value) is type(value)

    @pytest.mark.parametrize(
        "text",
        [
            "uint8 X=256",
            "uint8 X=-1",
            "int8 X=128",
            "byte X=200",
            "char X=-1",
            "int16 X=32768",
            "uint16 X=65536",
            "int32 X=2147483648",
            "uint32 X=4294967296",
            "uint64 X=18446744073709551616",
            "int64 X=9223372036854775808",
            "int32 X=0x10",
            "int32 X=1.0",
            "int32 X=",
            "int32 X=1=2",
            "int32 X==1",
            "int32 X=- 1",
            f"int32 X={'9' * 5000}",
            "float32 X=",
            "float32 X=1,5",
            "bool B=true",
            "bool B=yes",
            "bool B=",
            "bool B=" + "(" * 90 + ")" * 90,
            "bool B={[]}",
            f"bool B={'1' * 5000}",
            "time T=1",
            "duration D=1",
            "int32[] X=1",
            "Point P=1",
            "X=1",
            "=1",
            "int32 =1",
            "int32 A B=1",
            "int32 1A=1",
            "string A B=x",
            "string =x",
            "string\tA=x",
            "  string A=x",
        ],
    )
    def test_illegal_constants_are_refused(self, text: str) -> None:
        with pytest.raises(DefinitionError) as caught:
            constant(text)
        assert caught.value.line == 1
        assert len(str(caught.value)) < 300

    def test_an_indented_string_constant_is_read_from_a_peer(self) -> None:
        """genmsg takes the indentation for the separator and makes a name that no generator can use."""
        assert constant("  string A=x", lenient=True).name == "A"
        with pytest.raises(DefinitionError, match="must start the line"):
            constant("  string A=x")


class TestServices:
    """Request and response, separated by a line that starts with `---`."""

    def test_both_parts_are_messages(self) -> None:
        spec = parse_service("bool data\n---\nbool success\nstring message\n", "std_srvs/SetBool")
        assert spec.request.name == "std_srvs/SetBoolRequest"
        assert spec.request.text == "bool data\n"
        assert [f.name for f in spec.response.fields] == ["success", "message"]
        assert spec.response.text == "bool success\nstring message\n\n"  # genmsg adds the last one too

    @pytest.mark.parametrize("text", ["int32 a", "int32 a\n---", "int32 a\n--- words\n"])
    def test_a_response_may_be_missing(self, text: str) -> None:
        spec = parse_service(text, "p/S")
        assert len(spec.request.fields) == 1
        assert spec.response.fields == ()

    def test_a_second_separator_is_ignored(self) -> None:
        spec = parse_service("int8 a\n---\nint8 b\n----\nint8 c\n", "p/S")
        assert [f.name for f in spec.response.fields] == ["b", "c"]

    def test_an_indented_separator_is_none(self) -> None:
        with pytest.raises(DefinitionError) as caught:
            parse_service("int8 a\n ---\nint8 b", "p/S")
        assert caught.value.line == 2

    def test_lines_are_counted_through_the_file(self) -> None:
        with pytest.raises(DefinitionError) as caught:
            parse_service("int8 a\n---\nint8 b\nint8\n", "p/S", file="S.srv")
        assert (caught.value.file, caught.value.line) == ("S.srv", 4)


class TestActions:
    """Goal, result and feedback; actionlib makes seven messages of them."""

    TEXT = "int32 order\n---\nint32[] sequence\n---\nint32[] partial\n"

    def test_there_are_seven_messages(self) -> None:
        spec = parse_action(self.TEXT, "pkg/Fib")
        assert sorted(spec.messages) == sorted(
            "pkg/Fib" + s
            for s in ("Goal", "Result", "Feedback", "ActionGoal", "ActionResult", "ActionFeedback", "Action")
        )
        assert [str(f.type) for f in spec.messages["pkg/FibAction"].fields] == [
            "pkg/FibActionGoal",
            "pkg/FibActionResult",
            "pkg/FibActionFeedback",
        ]
        assert spec.messages["pkg/FibActionGoal"].has_header
        assert spec.goal.text == (
            "# ====== DO NOT MODIFY! AUTOGENERATED FROM AN ACTION DEFINITION ======\nint32 order\n"
        )

    @pytest.mark.parametrize("text", ["", "int8 a", "int8 a\n---\nint8 b", "---\n---\n---\n"])
    def test_three_parts_are_needed(self, text: str) -> None:
        with pytest.raises(DefinitionError, match="expected three"):
            parse_action(text, "p/A", file="A.action")

    def test_lines_are_counted_through_the_file(self) -> None:
        with pytest.raises(DefinitionError) as caught:
            parse_action("int8 a\n---\nint8 b\n---\n\nint8\n", "p/A", file="A.action")
        assert caught.value.line == 6
        with pytest.raises(DefinitionError) as caught:
            parse_action("int8\n---\n---\n", "p/A")
        assert caught.value.line == 1


def test_array_lengths_keep_their_spelling() -> None:
    """The md5 text holds `int32[007]` as it is written."""
    (field,) = parse("int32[007] a").fields
    assert field.type.array_length == 7
    assert str(field.type) == "int32[007]"
    assert str(parse("int32[0] a").fields[0].type) == "int32[0]"
    assert str(parse("int32[7] a").fields[0].type) == "int32[7]"


def test_definition_errors_are_ros_errors_and_value_errors() -> None:
    """Programs may catch either."""
    with pytest.raises(RosError):
        parse("x")
    with pytest.raises(ValueError):
        parse("x")


@pytest.mark.parametrize("lenient", [True, False])
def test_a_string_constant_without_a_name(lenient: bool) -> None:
    """`string =x` is refused like any other nameless constant."""
    with pytest.raises(DefinitionError, match="is not a name of a constant"):
        parse_message("string =x\n", "my_msgs/T", file="T.msg", lenient=lenient)
