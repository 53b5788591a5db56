"""Every message, service and action type of msgdefs: our bytes are genpy's, and each reads the other's."""

from __future__ import annotations

import json
import random
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto.codec import decode, encode, message_class
from rosproto.codec.binding import from_plain, to_plain
from rosproto.codec.layout import RANGES_BY_CODE, FieldLayout, Layout
from rosproto.msg import bundled
from tests.interop.genpy_build import write_definitions

HERE = Path(__file__).resolve().parent
PYTHON = "/usr/bin/python3"
VALUES_PER_TYPE = 3
WORDS = ["", "map", "base_link", "Wüste", "地图", 'quote " back \\ tab \t', "x" * 70]


def all_types() -> list[str]:
    """Messages (those of actions included), service requests and responses."""
    library = bundled()
    names: list[str] = []
    for package in library.packages():
        names += library.messages(package)
        names += [name + part for name in library.services(package) for part in ("Request", "Response")]
    return names


class Rng(random.Random):
    """Random numbers; with `odd_times`, nanoseconds of a second and more are among them."""

    odd_times = True


def random_plain(layout: Layout, rng: Rng) -> dict[str, Any]:
    return {field.name: random_field(field, rng) for field in layout.fields}


def random_field(field: FieldLayout, rng: Rng) -> Any:
    if not field.is_array:
        return random_one(field, rng)
    count = rng.choice([0, 1, 2, 5]) if field.length is None else field.length
    items = [random_one(field, rng) for _ in range(count)]
    return bytes(items) if field.code == "B" else items


def random_one(field: FieldLayout, rng: Rng) -> Any:
    if field.layout is not None:
        return random_plain(field.layout, rng)
    if field.kind == "string":
        return rng.choice(WORDS)
    if field.kind == "time":
        low, high = RANGES_BY_CODE[field.code[0]]
        nsecs = [0, 999_999_999, rng.randint(low, high)] if rng.odd_times else [123_456_789]
        return (rng.randint(low, high), rng.choice(nsecs))
    if field.code == "?":
        return rng.random() < 0.5
    if field.code in RANGES_BY_CODE:
        low, high = RANGES_BY_CODE[field.code]
        return rng.choice([low, high, rng.randint(low, high)])
    size = 4 if field.code == "f" else 8
    special = [-0.0, float("inf"), 5e-324 if size == 8 else 1e-45, 1.0]
    return rng.choice([*special, *struct.unpack("<" + field.code * 4, rng.randbytes(size * 4))])


def as_json(layout: Layout, plain: dict[str, Any]) -> list[Any]:
    return [field_json(field, plain[field.name]) for field in layout.fields]


def field_json(field: FieldLayout, value: Any) -> Any:
    if isinstance(value, bytes):
        return {"hex": value.hex()}
    if field.is_array:
        return [one_json(field, item) for item in value]
    return one_json(field, value)


def one_json(field: FieldLayout, value: Any) -> Any:
    if field.layout is not None:
        return as_json(field.layout, value)
    if field.kind == "time":
        return list(value)
    return {"float": struct.pack("<d", value).hex()} if field.code in ("f", "d") else value


def canonised(value: Any) -> Any:
    """Times as genpy has them after decoding: nsecs below 1e9."""
    if isinstance(value, dict):
        return {name: canonised(item) for name, item in value.items()}
    if isinstance(value, list):
        return [canonised(item) for item in value]
    if isinstance(value, tuple):
        return (value[0] + value[1] // 10**9, value[1] % 10**9)
    return value


class Case:
    """One message of one type, as we have it and as genpy answered."""

    def __init__(self, name: str, seed: int) -> None:
        self.name = name
        self.cls = message_class(name)
        binding = self.cls._binding
        assert binding is not None
        self.layout = binding.layout
        rng = Rng(f"{name} {seed}")
        self.seed = seed
        rng.odd_times = seed != 0
        self.message = from_plain(binding, random_plain(self.layout, rng))
        self.data = encode(self.message)
        self.answer: dict[str, Any] = {}

    def question(self) -> str:
        values = as_json(self.layout, to_plain(self.layout, self.message))
        return json.dumps({"type": self.name, "values": values, "bytes": self.data.hex()})


@pytest.fixture(scope="module")
def cases(ros_installed: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Case]]:
    """All types with random values, answered by one genpy process."""
    folder = tmp_path_factory.mktemp("genpy")
    write_definitions(folder / "definitions")
    made = [Case(name, seed) for name in all_types() for seed in range(VALUES_PER_TYPE)]
    (folder / "questions").write_text("\n".join(case.question() for case in made) + "\n", "utf-8")
    generated = str(folder / "generated")
    for command in (
        [PYTHON, str(HERE / "genpy_build.py"), str(folder / "definitions"), generated],
        [
            PYTHON,
            str(HERE / "genpy_codec_peer.py"),
            generated,
            str(folder / "questions"),
            str(folder / "answers"),
        ],
    ):
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr[-3000:]
    answers = (folder / "answers").read_text("utf-8").splitlines()
    for case, line in zip(made, answers, strict=True):
        case.answer = json.loads(line)
    return made


def test_md5sums_are_genpys(cases: list[Case]) -> None:
    """The classes agree on what they are."""
    assert {c.name: c.cls._md5sum for c in cases} == {c.name: c.answer["md5sum"] for c in cases}


def test_our_bytes_are_genpys(cases: list[Case]) -> None:
    """The same values become the same bytes, bit for bit."""
    wrong = [case.name for case in cases if case.data.hex() != case.answer["bytes"]]
    assert not wrong
    assert len({case.name for case in cases}) > 400


def test_both_read_the_same_values(cases: list[Case]) -> None:
    """What we decode is what genpy decodes from the same bytes; compared with canonical times: genpy does that."""
    wrong = []
    for case in cases:
        assert encode(decode(case.cls, case.data)) == case.data
        ours = as_json(case.layout, canonised(to_plain(case.layout, decode(case.cls, case.data))))
        if ours != case.answer["values"]:
            wrong.append((case.name, ours, case.answer["values"]))
    assert not wrong, wrong[:2]


def test_the_text_is_genpys(cases: list[Case]) -> None:
    """`str(msg)` is the same."""
    wrong = []
    for case in (case for case in cases if case.seed == 0):
        rospy = decode(message_class(case.name, value_style="rospy"), case.data)
        theirs = case.answer["text"]
        if case.name == "woosh_msgs/NavMode":
            theirs = theirs.replace("in_:", "in:")  # genpy renames fields that are Python keywords
        if str(rospy) != theirs:
            wrong.append((case.name, str(rospy), theirs))
    assert not wrong, wrong[:2]
