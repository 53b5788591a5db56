"""Our reading of definitions beside genmsg's own: accepted or refused, md5sum, full text, fields, constants.

Random definitions are compared by tests/interop/compare. Where the two differ on purpose (see rosproto/msg/parser.py) the case is listed in `DIFFERENCES`, with genmsg's
side of it, so that the list stays true.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rosproto.msg import bundled
from rosproto.selftest.computing import known_md5sums
from tests.interop.compare.comparison import Case, debian
from tests.interop.compare.definitions import USED, message, read, service
from tests.support import ros

pytestmark = pytest.mark.interop


def genmsg(cases: list[Case]) -> list[dict[str, Any]]:
    """Ask genmsg about all cases in one process."""
    ros.require_ros("genmsg")
    with debian("http://127.0.0.1:1") as peer:
        return [peer.ask("definition", case) for case in cases]


TRICKY = [
    "", "\n", "# a", "#", " ", "int8 a", "int8 a\n", "int8 a\r\n", "int8 a\n\n\nint8 b", "\tint8 a", "int8\ta", "int8 a\t",
    "int8 \ta", "int8 a # x", "int8 a#x", "int8 a#=1", "int8 # a", "int8 a b", "int8", "a int8", "int8 1a", "int8 _a",
    "int8 a_", "int8 a.b", "int8 a-b", "int8 class", "int8 a;", "int8 a\nint8 a", "int8 a\rint8 b", "int8 a\x0bint8 b",
    "int8\x0c a", "int8[] a", "int8[3] a", "int8[0] a", "int8[007] a", "int8[-1] a", "int8[x] a", "int8[ ] a", "int8[3]] a",
    "int8[[3] a", "int8[][] a", "int8[3][] a", "int8[3]b a", "int8[1_0] a", "int8 [3] a", "[] a", "[3] a", "int8 a[3]",
    "Header h", "Header header", "Header[] h", "Header[2] h", "int8 a\nHeader header", "std_msgs/Header header",
    "std_msgs/Header[] header", "string header", "U u", "U[] u", "U[3] u", "p/U u", "p/U[7] u", "V v", "q/U u", "p/q/U u",
    "/U u", "p/ u", "p//U u", "U/ u", "u U", "T t", "T[] t", "W w", "X x", "U u\nV v\nU w", "U U", "time t", "duration d",
    "Time t", "byte b", "char c", "bool b", "string s", "float32 f", "float64[2] f", "uint64 x", "int128 x", "wstring s",
    "int8 A=1", "int8 A = 1", "int8  A  =  1  # x", "int8 A= 1", "int8 A =1", "int8 A=", "int8 A=1=2", "int8 A==1",
    "int8 A=127", "int8 A=128", "int8 A=-128", "int8 A=-129", "uint8 A=255", "uint8 A=256", "uint8 A=-1", "byte A=200",
    "byte A=-128", "char A=200", "char A=-1", "int16 A=32768", "uint16 A=65535", "int32 A=2147483647",
    "int32 A=2147483648", "uint32 A=4294967295", "uint32 A=4294967296", "int64 A=9223372036854775807",
    "uint64 A=18446744073709551615", "int8 A=0x1", "int8 A=1.0", "int8 A=1e1", "int8 A=+1", "int8 A=- 1", "int8 A=1_0",
    "int8 A=007", "int8 A=a", "int8 A=1 2", "int8 A='1'", "float32 A=1.50", "float32 A=1", "float32 A=1e400",
    "float32 A=nan", "float64 A=-inf", "float64 A=1_0.5", "float64 A=0x1p3", "float64 A=1,5", "float64 A=1f", "float64 A=",
    "bool A=True", "bool A=False", "bool A=true", "bool A=1", "bool A=0", "bool A=2", "bool A=-1", "bool A=0.0",
    "bool A=None", "bool A=''", "bool A='a'", "bool A=[]", "bool A=[1]", "bool A=(", "bool A=a", "bool A=1+2j", "bool A=1+1",
    "bool A={1:2}", "bool A={[]}", "bool A= True", "bool A=b'x'", "bool A=", "string A=", "string A=x", "string A= x ",
    "string A=#x", "string A=x # y", "string  A=x", "string A =x", "string\tA=x", "string \tA=x", "string A='x'", "string A==",
    "string A=x=y", "string A=\t", "string[] A=x", "time A=1", "duration A=1", "Header A=1", "U A=1", "A=1", "=1", "=", "int8=1",
    "int8 A=1\nint8 A=1", "int8 A=1\nint8 A=2", "int8 a\nint8 A=1", "string A=\u4e2d", "int8 a # \u4e2d",
    "string A=x\r\n", "string A=\u00a0x\u00a0", "int8\u00a0a", "int8 a\u00a0", "\ufeffint8 a", "# \ufeff\nint8 a",
    "int8 a \\", "---", "int8 a\n---\nint8 b", "====", "MSG: p/T", "int8 a \u2028 # x", "int8 a\x1c\n", "int8\x1ca",
]  # fmt: skip

SERVICES = [
    "", "---", "---\n", "int8 a", "int8 a\n---", "int8 a\n---\n", "---\nint8 a", "int8 a\n---\nint8 a\n", "int8 a\r\n---\r\nint8 b\r\n",
    "int8 a\n----\nint8 b", "int8 a\n--- x\nint8 b", "int8 a\n ---\nint8 b", "int8 a\n--\nint8 b", "int8 a\n---\nint8 b\n---\nint8 c",
    "int8 a\n---\nint8 a\nint8 a", "int8 A=1\n---\nint8 A=2\nint8 a\n", "# x\n---\n# y\n", "Header header\n---\nHeader h",
    "---\n---\n", "int8\n---\n", "---\nint8\n", "string A=--- x\n---\nstring B=---\n",
]  # fmt: skip

DIFFERENCES = {
    "int8 gr\u00f6sse": "accepts a name that is not an identifier in C++",
    "int8[\u0663] a": "reads other digits",
    "int8 =1": "accepts a constant without a name",
    "int8 A B=1": "accepts a name with a blank",
    "int8 1A=1": "accepts a name that begins with a digit",
    "string A B=x": "accepts a name with a blank",
    "  string A=x": "takes the indentation for the separator: the name becomes `string A`",
    "uint64 A=18446744073709551616": "compares with a rounded float",
    "int64 A=9223372036854775808": "compares with a rounded float",
    "int64 A=-9223372036854775809": "compares with a rounded float",
}


def differing(cases: list[Case]) -> list[str]:
    """Cases where we and genmsg do not say the same."""
    wrong = []
    for case, theirs in zip(cases, genmsg(cases), strict=True):
        mine = read(case)
        if ("error" in mine) != ("error" in theirs) or ("error" not in mine and mine != theirs):
            wrong.append(f"{case['types'][case['main']]!r}:\n  we     {mine}\n  genmsg {theirs}")
    return wrong


def test_tricky_messages_are_read_alike() -> None:
    """Accepted, refused and hashed as genmsg does, full text included."""
    assert not differing([message(text, **USED) for text in TRICKY])


def test_tricky_services_are_read_alike() -> None:
    """Also where the separator is odd, missing or there twice."""
    assert not differing([service(text) for text in SERVICES])


def test_the_differences_are_exactly_these() -> None:
    """genmsg accepts each of them, and no generator can make code of it; we refuse with a reason."""
    cases = [message(text) for text in DIFFERENCES]
    for (text, why), case, theirs in zip(DIFFERENCES.items(), cases, genmsg(cases), strict=True):
        assert "error" in read(case), text
        assert "error" not in theirs, (text, why, theirs)


def test_bundled_definitions_are_read_alike() -> None:
    """Each message and service that ships, with the full text that goes into connection headers."""
    library = bundled()
    cases = []
    for package in library.packages():
        for kind, names in (("msg", library.messages(package)), ("srv", library.services(package))):
            for name in names:
                used = library.dependencies(name, kind=kind)
                own = library.message(name).text if kind == "msg" else library.service(name).text
                texts = {**{other: library.message(other).text for other in used}, name: own}
                cases.append({"types": texts, "main": name, "kind": kind})
    assert len(cases) > 350
    assert not differing(cases)[:3]


def test_the_table_of_the_selftest_is_genmsgs() -> None:
    """Every md5sum by which an installation is checked (the first eight digits), and no type is left out."""
    library = bundled()
    table = {(kind, name): digits for digits, kind, name in known_md5sums()}
    cases = []
    for kind, name in table:
        used = library.dependencies(name, kind=kind)
        own = library.message(name).text if kind == "msg" else library.service(name).text
        texts = {**{other: library.message(other).text for other in used}, name: own}
        cases.append({"types": texts, "main": name, "kind": kind})
    assert len(cases) == sum(
        len(library.messages(package)) + len(library.services(package)) for package in library.packages()
    )
    for (kind, name), answer in zip(table, genmsg(cases), strict=True):
        assert answer["md5"].startswith(table[kind, name]), (kind, name, answer)


def test_a_definition_without_a_comment_is_upstreams_text() -> None:
    """What recorders write into bags is then the same to the byte; where upstream has comments, ours are our own."""
    share = Path("/usr/share")
    plain = [
        (str(path.relative_to(ros.MSGDEFS)), path.read_bytes(), theirs.read_bytes())
        for path in sorted(ros.MSGDEFS.glob("*/msg/*.msg"))
        for theirs in [share / path.relative_to(ros.MSGDEFS)]
        if theirs.exists() and b"#" not in theirs.read_bytes()
    ]
    ros.require(len(plain) > 20, "Debian's packages of messages are not installed")
    assert [name for name, ours, theirs in plain if ours != theirs] == []
