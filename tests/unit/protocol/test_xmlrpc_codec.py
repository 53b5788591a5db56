"""XML-RPC documents: encoding, decoding, refusals."""

from __future__ import annotations

import datetime
import math
import time
import xmlrpc.client as stdlib

import numpy as np
import pytest

from rosproto.errors import LocalProtocolError, RemoteProtocolError, TooLarge
from rosproto.protocol import xmlrpc
from rosproto.protocol.wire_limits import Limits

VALUES = [
    "",
    "  two blanks  ",
    "line\nline\ttab",
    "<&>\"' ]]>",
    "Grüße 机器人 😀",
    0,
    -(2**31),
    2**31 - 1,
    True,
    False,
    0.1,
    -1e-300,
    1.7976931348623157e308,
    math.inf,
    b"",
    bytes(range(256)),
    [],
    {},
    [1, [2.5, [True, "x"]], {}],
    {"a": {"b c": [1, {"": "empty key"}]}, "<&>": 1},
    xmlrpc.DateTime("19980717T14:08:55"),
]


def response(inner: str) -> bytes:
    return f"<?xml version='1.0'?><methodResponse><params><param>{inner}</param></params></methodResponse>".encode()


def read(inner: str) -> object:
    return xmlrpc.decode_response(response(inner))


def same(one: object, other: object) -> bool:
    return one == other and repr(one) == repr(other)  # tells True from 1, and 1.0 from 1


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_what_is_written_is_read_back_with_its_type(value: object) -> None:
    assert same(xmlrpc.decode_response(xmlrpc.encode_response(value)), value)
    method, params = xmlrpc.decode_call(xmlrpc.encode_call("m", [value, value]))
    assert method == "m"
    assert same(params, [value, value])


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_pythons_own_xmlrpc_reads_what_is_written_and_writes_what_is_read(value: object) -> None:
    (theirs,), method = stdlib.loads(xmlrpc.encode_call("m", [value]), use_builtin_types=False)
    assert method == "m"
    if isinstance(value, bytes):
        assert theirs.data == value
    elif isinstance(value, xmlrpc.DateTime):
        assert theirs.value == value
    else:
        assert same(theirs, value)
    document = stdlib.dumps((theirs,), methodresponse=True).encode()
    assert same(xmlrpc.decode_response(document), value)


@pytest.mark.promise("roscpp's parser knows five entities, no numeric references")
def test_the_written_form_is_one_that_roscpps_parser_reads() -> None:
    assert xmlrpc.encode_call("m", ["a\"'<&>", 1, True, 0.5, [""], {"k": b"\0"}]) == (
        b'<?xml version="1.0"?><methodCall><methodName>m</methodName><params>'
        b"<param><value><string>a\"'&lt;&amp;&gt;</string></value></param>"
        b"<param><value><int>1</int></value></param>"
        b"<param><value><boolean>1</boolean></value></param>"
        b"<param><value><double>0.5</double></value></param>"
        b"<param><value><array><data><value><string></string></value></data></array></value></param>"
        b"<param><value><struct><member><name>k</name><value><base64>AA==</base64></value></member></struct></value>"
        b"</param></params></methodCall>"
    )


@pytest.mark.promise("roscpp's parser knows five entities, no numeric references")
def test_no_numeric_references_and_no_cdata_are_written() -> None:
    document = xmlrpc.encode_response("".join(map(chr, range(0x20, 0x300))) + "\t\n\r]]>")
    assert b"&#" not in document
    assert b"CDATA" not in document


@pytest.mark.parametrize("value", [2**31, -(2**31) - 1, 2**63, [0, 99999999999]])
def test_integers_beyond_32_bits_are_our_error(value: object) -> None:
    with pytest.raises(LocalProtocolError, match="32 bits"):
        xmlrpc.encode_call("setParam", ["/me", "/key", value])


@pytest.mark.parametrize("character", ["\0", "\x01", "\x0b", "\x1b", "\x1f", "\ufffe", "\uffff", "\ud800"])
def test_characters_that_xml_cannot_carry_are_our_error(character: str) -> None:
    for value in (f"ab{character}", {character: 1}):
        with pytest.raises(LocalProtocolError, match=f"U\\+{ord(character):04X}"):
            xmlrpc.encode_call("m", [value])
    with pytest.raises(LocalProtocolError):
        xmlrpc.encode_call(f"m{character}", [])


def test_the_error_says_which_argument() -> None:
    with pytest.raises(LocalProtocolError, match="m argument 1: character 2"):
        xmlrpc.encode_call("m", ["ok", "ab\x01"])


def test_a_fault_text_is_made_sendable() -> None:
    with pytest.raises(xmlrpc.Fault, match=r"bad\? \?") as caught:
        xmlrpc.decode_response(xmlrpc.encode_fault(-1, "bad\x00 \udcff"))
    assert (caught.value.code, caught.value.text) == (-1, "bad? ?")


@pytest.mark.parametrize("value", [None, object(), {1: 2}, 1j, {1, 2}, lambda: 0])
def test_other_types_are_our_error(value: object) -> None:
    with pytest.raises(LocalProtocolError, match="XML-RPC"):
        xmlrpc.encode_response([value])


def test_a_container_that_holds_itself_is_our_error() -> None:
    circle: list[object] = []
    circle.append(circle)
    with pytest.raises(LocalProtocolError, match="holds itself"):
        xmlrpc.encode_response(circle)


@pytest.mark.parametrize(
    ("value", "read_back"),
    [
        (np.float64(0.1), 0.1),
        (np.float32(0.5), 0.5),
        (np.int64(7), 7),
        (np.bool_(True), True),
        (np.arange(3), [0, 1, 2]),
        ((1, "a"), [1, "a"]),
        (bytearray(b"x"), b"x"),
        (memoryview(b"x"), b"x"),
        (datetime.datetime(2026, 11, 2, 3, 4, 5), "20261102T03:04:05"),
    ],
)
def test_close_relatives_are_sent_as_what_they_resemble(value: object, read_back: object) -> None:
    assert same(xmlrpc.decode_response(xmlrpc.encode_response(value)), read_back)


@pytest.mark.parametrize(
    ("inner", "value"),
    [
        ("<value></value>", ""),
        ("<value/>", ""),
        ("<value>  a b </value>", "  a b "),
        ("<value>&lt;&amp;&gt;&quot;&apos;&#65;</value>", "<&>\"'A"),
        ("<value><![CDATA[<x>]]></value>", "<x>"),
        ("<value><string> a </string></value>", " a "),
        ("<value>\n <int> -5\n</int> </value>", -5),
        ("<value><i4>+5</i4></value>", 5),
        ("<value><i8>99999999999</i8></value>", 99999999999),
        ("<value><ex:i8 xmlns:ex='x'>1</ex:i8></value>", 1),
        ("<value><nil/></value>", None),
        ("<value><ex:nil/></value>", None),
        ("<value><boolean>1</boolean></value>", True),
        ("<value><boolean>true</boolean></value>", True),
        ("<value><double>1.0000000000000001e-01</double></value>", 0.1),
        ("<value><double>-inf</double></value>", -math.inf),
        ("<value><base64>\nAAEC\nAw==\n</base64></value>", b"\0\1\2\3"),
        ("<value><array><data></data></array></value>", []),
        (
            "<value><array> <data> <value>1</value> <value><i4>2</i4></value> </data> </array></value>",
            ["1", 2],
        ),
        ("<value><struct><member><name>a</name><value>1</value></member></struct></value>", {"a": "1"}),
        ("<value><struct><member><name></name><value/></member></struct></value>", {"": ""}),
        ("<value attribute='x'><int>1</int></value><!-- comment -->", 1),
        ("", None),  # roscpp writes nothing for a result that was not set
        ("<value><struct><member><name>a</name></member></struct></value>", {"a": None}),
    ],
)
def test_reading_is_lenient_where_peers_differ(inner: str, value: object) -> None:
    assert same(read(inner), value)


@pytest.mark.promise("`nan` and `inf` occur as texts of doubles")
def test_nan_is_read() -> None:
    assert math.isnan(read("<value><double>nan</double></value>"))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "inner",
    [
        "<value><int></int></value>",
        "<value><int>1.5</int></value>",
        "<value><int>1_0</int></value>",
        "<value><int>١</int></value>",
        "<value><int>" + "9" * 5000 + "</int></value>",
        "<value><int>+-1</int></value>",
        "<value><double></double></value>",
        "<value><double>1_0.0</double></value>",
        "<value><double>" + "1" * 5000 + "</double></value>",
        "<value><boolean>2</boolean></value>",
        "<value><base64>A</base64></value>",
        "<value><base64>ü</base64></value>",
        "<value><int>1</int><int>2</int></value>",
        "<value>text<int>1</int></value>",
        "<value><int>1</int>text</value>",
        "<value><unknown>1</unknown></value>",
        "<value><int><int>1</int></int></value>",
        "<value><array></array></value>",
        "<value><array><value>1</value></array></value>",
        "<value><array><data/><data/></array></value>",
        "<value><struct><member><value>1</value></member></struct></value>",
        "<value><struct><value>1</value></struct></value>",
        "<value>1</value><value>2</value>",
        "text",
        "<value>",
        "<value>&unknown;</value>",
        "<value>\x01</value>",
    ],
)
def test_nonsense_is_the_peers_error(inner: str) -> None:
    with pytest.raises(RemoteProtocolError, match="XML-RPC"):
        read(inner)


@pytest.mark.parametrize(
    "document",
    [
        b"",
        b"not xml",
        b"\0" * 100,
        b"<html><body>404</body></html>",
        b"<methodResponse></methodResponse>trailing",
        b"<methodCall></methodCall>",
        b"<methodCall><methodName></methodName></methodCall>",
        xmlrpc.encode_response(1),
        b"\xff\xfe<\0m\0",
        b"<?xml version='1.0' encoding='zlib'?><methodCall/>",
    ],
)
def test_documents_that_are_no_call_are_refused(document: bytes) -> None:
    with pytest.raises(RemoteProtocolError, match="XML-RPC"):
        xmlrpc.decode_call(document)


def test_a_response_has_one_value_and_is_no_call() -> None:
    with pytest.raises(RemoteProtocolError, match="expected a <methodResponse>"):
        xmlrpc.decode_response(xmlrpc.encode_call("m"))
    two = b"<methodResponse><params><param><value/></param><param><value/></param></params></methodResponse>"
    with pytest.raises(RemoteProtocolError, match="one value"):
        xmlrpc.decode_response(two)


def test_a_call_without_params_has_no_arguments() -> None:
    document = b"<?xml version='1.0'?>\r\n<methodCall>\r\n<methodName>getPid</methodName></methodCall>\r\n"
    assert xmlrpc.decode_call(document) == ("getPid", [])


def test_faults_are_raised() -> None:
    document = stdlib.dumps(stdlib.Fault(7, "no"), methodresponse=True).encode()
    with pytest.raises(xmlrpc.Fault) as caught:
        xmlrpc.decode_response(document)
    assert (caught.value.code, caught.value.text) == (7, "no")
    document = b"<methodResponse><fault><value><struct/></value></fault></methodResponse>"
    with pytest.raises(xmlrpc.Fault) as caught:
        xmlrpc.decode_response(document)
    assert (caught.value.code, caught.value.text) == (0, "")


def test_a_fault_without_struct_is_the_peers_error() -> None:
    with pytest.raises(RemoteProtocolError, match="fault"):
        xmlrpc.decode_response(b"<methodResponse><fault><value>1</value></fault></methodResponse>")


def test_latin1_is_read_when_declared_and_refused_when_not() -> None:
    document = response("<value>gr\xfc\xdfe</value>").decode()
    declared = document.replace("version='1.0'", "version='1.0' encoding='ISO-8859-1'").encode("latin-1")
    assert xmlrpc.decode_response(declared) == "gr\xfc\xdfe"
    with pytest.raises(RemoteProtocolError, match="not UTF-8"):
        xmlrpc.decode_response(document.encode("latin-1"))


BOMB = "<!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
    f"<!ENTITY {chr(98 + i)} '{f'&{chr(97 + i)};' * 10}'>" for i in range(9)
)


@pytest.mark.promise("XML with a DOCTYPE or entities is refused", "rospy's slave API expands entities")
@pytest.mark.parametrize(
    "prologue",
    [
        "<!DOCTYPE methodResponse>",
        BOMB + "]>",
        "<!DOCTYPE x [<!ENTITY e SYSTEM 'file:///etc/passwd'>]>",
        "<!DOCTYPE x SYSTEM 'http://127.0.0.1:1/x.dtd'>",
    ],
)
def test_doctype_and_entities_are_refused(prologue: str) -> None:
    document = f"<?xml version='1.0'?>{prologue}<methodCall><methodName>&j;</methodName></methodCall>"
    with pytest.raises(RemoteProtocolError, match="DOCTYPE"):
        xmlrpc.decode_call(document.encode())


def nested(levels: int) -> bytes:
    return response("<value><array><data>" * levels + "</data></array></value>" * levels)


def test_xml_depth_bounds_the_nesting() -> None:
    limits = Limits(xml_depth=5)
    assert xmlrpc.decode_response(nested(5), limits) == [[[[[]]]]]
    with pytest.raises(TooLarge, match="xml_depth"):
        xmlrpc.decode_response(nested(6), limits)
    structs = response("<value><struct><member><name>a</name>" * 6 + "</member></struct></value>" * 6)
    with pytest.raises(TooLarge, match="xml_depth"):
        xmlrpc.decode_response(structs, limits)


def test_depth_is_counted_along_a_path_not_over_the_document() -> None:
    flat = response("<value><array><data>" + "<value><struct/></value>" * 100 + "</data></array></value>")
    assert xmlrpc.decode_response(flat, Limits(xml_depth=2)) == [{}] * 100


@pytest.mark.promise("A hundred thousand nested arrays in one request")
def test_a_hundred_thousand_nested_arrays_are_refused() -> None:
    with pytest.raises(TooLarge, match="xml_depth"):  # they kill a roscpp node
        xmlrpc.decode_response(nested(100_000))


def test_what_is_sent_can_be_received() -> None:
    value: object = 1
    for _ in range(64):
        value = [value]
    assert xmlrpc.decode_response(xmlrpc.encode_response(value)) == value
    with pytest.raises(LocalProtocolError, match="nested"):
        xmlrpc.encode_response([value])


def test_xml_body_bytes_bounds_the_document() -> None:
    document = xmlrpc.encode_call("m")
    assert xmlrpc.decode_call(document, Limits(xml_body_bytes=len(document)))
    with pytest.raises(TooLarge, match="xml_body_bytes"):
        xmlrpc.decode_call(document, Limits(xml_body_bytes=len(document) - 1))


@pytest.mark.parametrize(
    "make",
    [
        lambda n: response("<value>" + "x" * (n * 16) + "</value>"),
        lambda n: response("<value><array><data>" + "<value>1</value>" * n + "</data></array></value>"),
        lambda n: response("<value " + " ".join(f"a{i}='{i}'" for i in range(n)) + ">x</value>"),
        lambda n: response("<value>" + "&amp;" * n + "</value>"),
        lambda n: response("<value>" + "<!-- x -->" * n + "</value>"),
    ],
    ids=["long text", "many values", "many attributes", "many entities", "many comments"],
)
def test_time_is_proportional_to_the_document(make) -> None:  # type: ignore[no-untyped-def]
    def cost(n: int) -> float:
        document = make(n)
        best = math.inf
        for _ in range(3):
            start = time.process_time()
            xmlrpc.decode_response(document)
            best = min(best, time.process_time() - start)
        return best

    small, large = cost(2_000), cost(20_000)
    assert large < 40 * small + 0.05  # ten times the input; quadratic would be a hundred


def test_views_and_bytearrays_are_read_too() -> None:
    document = bytearray(xmlrpc.encode_call("m", [1]))
    assert xmlrpc.decode_call(memoryview(document)) == xmlrpc.decode_call(document) == ("m", [1])
