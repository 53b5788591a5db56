"""Feeds hostile bytes to targets: any input gives a value or a documented error, nothing else, and soon.

A target is a function of bytes. It catches the errors its code documents; whatever else leaves it is a
finding. It may return a short text that says what kind of outcome this was: inputs with a new kind are kept
and mutated further, which leads the plain mutation loop deeper.

A module `tests/fuzz/target_<part>.py` offers `TARGETS = {name: function}`, and may offer
`TOKENS = {name: [bytes, ...]}`, words of its format. Seeds are the files in `tests/fuzz/corpus/<name>/`; a
finding is written to `tests/fuzz/found/<name>/`: mend the code, then move the file to the corpus.
"""

from __future__ import annotations

import hashlib
import importlib
import random
import re
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

Target = Callable[[bytes], object]

HERE = Path(__file__).resolve().parent
CORPUS = HERE / "corpus"
FOUND = HERE / "found"
GROWN = HERE / "grown"
MAX_BYTES = 1 << 14
SLOW_SECONDS = 2.0  # process time for one input of at most MAX_BYTES: only a broken bound takes so long
_NUMBERS = [0, 1, 2, 3, 4, 7, 8, 127, 128, 255, 256, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 10**9]


class Finding(Exception):
    """A target failed, or took too long. `data` is the input."""

    def __init__(self, target: str, data: bytes, why: str) -> None:
        super().__init__(f"{target}: {why} for {data[:200]!r}{'...' if len(data) > 200 else ''}")
        self.target = target
        self.data = data


def load() -> tuple[dict[str, Target], dict[str, list[bytes]]]:
    """All targets and tokens, by name."""
    targets: dict[str, Target] = {}
    tokens: dict[str, list[bytes]] = {}
    for path in sorted(HERE.glob("target_*.py")):
        module = importlib.import_module(f"tests.fuzz.{path.stem}")
        targets.update(module.TARGETS)
        tokens.update(getattr(module, "TOKENS", {}))
    return targets, tokens


def seeds(name: str) -> list[bytes]:
    """The seed inputs of a target, the empty one always among them."""
    folder = CORPUS / name
    files = sorted(path for path in folder.glob("*") if path.is_file()) if folder.is_dir() else []
    return [b"", *(path.read_bytes() for path in files)]


def run_one(name: str, target: Target, data: bytes) -> str:
    """Feed one input; the kind of its outcome.

    Raises:
        Finding: An undocumented error, or too slow.
    """
    start = time.process_time()
    try:
        outcome = target(data)
    except Exception as error:
        raise Finding(name, data, f"{type(error).__name__}: {error}") from error
    seconds = time.process_time() - start
    if seconds > SLOW_SECONDS:
        raise Finding(name, data, f"took {seconds:.1f} s of processor time")
    return kind(outcome)


def kind(outcome: object) -> str:
    """An outcome without what varies from input to input: numbers and quoted text."""
    text = "" if outcome is None else str(outcome)
    return re.sub(r"'[^']*'|\"[^\"]*\"|<[^>]*>|[0-9a-fx]*\d[0-9a-fx]*", "*", text)[:120]


def mutations(inputs: Sequence[bytes], tokens: Sequence[bytes], rng: random.Random) -> Iterator[bytes]:
    """Endless mutations; `inputs` may grow meanwhile."""
    while True:
        data = bytearray(rng.choice(inputs))
        for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
            rng.choice(_MUTATORS)(data, inputs, tokens, rng)
        yield bytes(data[:MAX_BYTES])


def fuzz(
    name: str,
    target: Target,
    tokens: Sequence[bytes],
    *,
    seed: int,
    seconds: float | None = None,
    runs: int | None = None,
) -> int:
    """The plain mutation loop: until `seconds` passed or `runs` were made. Returns how many were.

    Raises:
        Finding: See `run_one`.
    """
    rng = random.Random(f"{seed} {name}")
    inputs, kinds = list(seeds(name)), set()
    for data in inputs:
        kinds.add(run_one(name, target, data))
    end = None if seconds is None else time.monotonic() + seconds
    for number, data in enumerate(mutations(inputs, tokens, rng)):
        if number == runs or (end is not None and time.monotonic() >= end):
            return number
        outcome = run_one(name, target, data)
        if outcome not in kinds and len(kinds) < 2000:
            kinds.add(outcome)
            inputs.append(data)
    raise AssertionError("mutations are endless")


def fuzz_with_atheris(target: Target, name: str, seconds: float) -> None:
    """Coverage-guided fuzzing of one target; ends the process, as libFuzzer does."""
    import atheris  # type: ignore[import-not-found]  # optional

    # What is imported late, or made by generated code, must be there: instrumentation is for what exists now.
    for data in seeds(name):
        run_one(name, target, data)
    atheris.instrument_all()
    folder = CORPUS / name
    arguments = [sys.argv[0], f"-max_total_time={int(seconds)}", f"-max_len={MAX_BYTES}", "-timeout=10"]
    # libFuzzer keeps what it learns in the first folder: beside the seeds, not among them.
    for place in (FOUND / name, GROWN / name):
        place.mkdir(parents=True, exist_ok=True)
    arguments += [f"-artifact_prefix={FOUND / name}/", str(GROWN / name)]
    arguments += [str(folder)] if folder.is_dir() else []
    atheris.Setup(arguments, lambda data: run_one(name, target, data) and None)
    atheris.Fuzz()


def save(finding: Finding) -> Path:
    """Write a finding's input to a file named by its content."""
    folder = FOUND / finding.target
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / hashlib.sha256(finding.data).hexdigest()[:16]
    path.write_bytes(finding.data)
    return path


def report(finding: Finding) -> None:
    """Tell about a finding on stderr."""
    traceback.print_exception(finding.__cause__ or finding)
    print(f"FOUND {finding}\n  saved as {save(finding)}", file=sys.stderr)


# -- mutators: change `data` in place


def _flip(data: bytearray, _inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    if data:
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _byte(data: bytearray, _inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    if data:
        data[rng.randrange(len(data))] = rng.choice(
            (0, 9, 10, 13, 32, 34, 38, 60, 61, 62, 127, 128, 255, rng.randrange(256))
        )


def _number(data: bytearray, _inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    """A little-endian length somewhere, often at a place where one may be."""
    if len(data) >= 4:
        at = rng.choice((0, rng.randrange(len(data) - 3)))
        value = rng.choice((*_NUMBERS, len(data) - at - 4, len(data)))
        data[at : at + 4] = (value & 0xFFFFFFFF).to_bytes(4, "little")


def _digits(data: bytearray, _inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    """A decimal number in the text replaced by another."""
    found = list(re.finditer(rb"\d+", data))
    if found:
        match = rng.choice(found)
        data[match.start() : match.end()] = str(rng.choice(_NUMBERS)).encode() * rng.choice((1, 1, 1, 50))


def _delete(data: bytearray, _inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    start = rng.randint(0, len(data))
    del data[start : start + rng.choice((1, 2, 4, 16, len(data)))]


def _repeat(data: bytearray, _inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    start = rng.randint(0, len(data))
    piece = bytes(data[start : start + rng.choice((1, 4, 16, 64))])
    data[start:start] = piece * min(rng.choice((1, 2, 10, 200)), MAX_BYTES // (len(piece) + 1))


def _insert(data: bytearray, _inputs: Sequence[bytes], tokens: Sequence[bytes], rng: random.Random) -> None:
    at = rng.randint(0, len(data))
    data[at:at] = rng.choice(tokens) if tokens and rng.random() < 0.8 else rng.randbytes(rng.randint(1, 8))


def _splice(data: bytearray, inputs: Sequence[bytes], _tokens: Sequence[bytes], rng: random.Random) -> None:
    other = rng.choice(inputs)
    at, start = rng.randint(0, len(data)), rng.randint(0, len(other))
    data[at:] = other[start:] if rng.random() < 0.5 else other[start : start + 64] + bytes(data[at:])


_MUTATORS = (_flip, _byte, _number, _digits, _delete, _repeat, _insert, _insert, _splice)
