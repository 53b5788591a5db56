"""What clients send is parsed in pieces, in turns, and within a budget; clocks and transports are made up."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from types import SimpleNamespace
from typing import Any

import pytest

from rosproto.aio import BudgetedProtocol, ReadBudget
from rosproto.aio import read_budget as module

MESSAGE = b"m" * 100


class Clock:
    """The processor time of this thread, and the time of day, which goes on while the loop waits."""

    def __init__(self) -> None:
        self.used = 0.0

    def thread_time(self) -> float:
        return self.used

    def monotonic(self) -> float:
        return asyncio.get_running_loop().time() + self.used


class Transport:
    def __init__(self) -> None:
        self.reads, self.closing = True, False

    def pause_reading(self) -> None:
        self.reads = False

    def resume_reading(self) -> None:
        self.reads = True

    def write(self, data: bytes) -> None: ...

    def is_closing(self) -> bool:
        return self.closing

    def abort(self) -> None:
        self.closing = True


class Parser(asyncio.Protocol):
    """Takes `cost` seconds of the processor for each byte; pauses its transport after `pauses_after` bytes."""

    def __init__(self, clock: Clock, cost: float = 0.0, pauses_after: int | None = None) -> None:
        self.clock, self.cost, self.pauses_after = clock, cost, pauses_after
        self.pieces: list[bytes] = []
        self.transport: Any = None

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        self.pieces.append(data)
        self.clock.used += self.cost * len(data)
        if self.pauses_after is not None and len(self.bytes) >= self.pauses_after:
            self.pauses_after = None
            self.transport.pause_reading()

    @property
    def bytes(self) -> bytes:
        return b"".join(self.pieces)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    fake = SimpleNamespace(thread_time=clock.thread_time, monotonic=clock.monotonic)
    monkeypatch.setattr(module, "time", fake)
    return clock


def in_loop(test: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(test(), 20.0))


def connected(budget: ReadBudget, parser: asyncio.Protocol) -> tuple[BudgetedProtocol, Transport]:
    connection, transport = BudgetedProtocol(budget, parser), Transport()
    connection.connection_made(transport)  # type: ignore[arg-type]
    return connection, transport


def unwanted(transport: Any) -> None:
    raise AssertionError("it was cut off")


def test_bytes_arrive_whole_and_in_order_in_growing_pieces(clock: Clock) -> None:
    async def test() -> None:
        parser = Parser(clock)
        connection, transport = connected(ReadBudget(unwanted), parser)
        data = bytes(range(256)) * 1000
        connection.data_received(data)
        assert parser.bytes == data
        assert [len(piece) for piece in parser.pieces[:6]] == [1024, 2048, 4096, 8192, 16384, 16384]
        assert transport.reads

    in_loop(test)


@pytest.mark.promise("for five milliseconds at a time and half of the server's time")
def test_what_is_expensive_is_read_in_turns_and_its_transport_is_paused_meanwhile(clock: Clock) -> None:
    async def test() -> None:
        parser = Parser(clock, cost=1e-6)
        connection, transport = connected(ReadBudget(unwanted, overhead=9.0), parser)
        connection.data_received(b"p" * 50_000)
        assert len(parser.bytes) == 5 * 1024  # five milliseconds
        assert not transport.reads
        while not transport.reads:
            await asyncio.sleep(0.001)
        assert len(parser.bytes) == 50_000

    in_loop(test)


@pytest.mark.promise("bytes of a client that sends little are parsed before those of one that floods")
def test_one_that_sends_little_comes_before_those_that_flood(clock: Clock) -> None:
    """Its bytes are the next that are parsed, though sixty-three others wait."""

    async def test() -> None:
        budget = ReadBudget(unwanted, overhead=9.0)
        floods = [Parser(clock, cost=1e-6) for _ in range(63)]

        def pieces() -> int:
            return sum(len(parser.pieces) for parser in floods)

        driver = Parser(clock)
        connection, _ = connected(budget, driver)
        for parser in floods:
            connected(budget, parser)[0].data_received(b"p" * 50_000)
        while pieces() < 100:
            await asyncio.sleep(0.001)
        for count in range(1, 21):
            before = pieces()
            connection.data_received(MESSAGE)
            while len(driver.pieces) < count:
                assert pieces() == before
                await asyncio.sleep(0)
            await asyncio.sleep(0.003)

    in_loop(test)


def test_a_protocol_that_pauses_gets_nothing_until_it_resumes_and_then_not_at_once(clock: Clock) -> None:
    async def test() -> None:
        parser = Parser(clock, pauses_after=1)
        connection, transport = connected(ReadBudget(unwanted), parser)
        connection.data_received(b"x" * 3000)
        assert (len(parser.bytes), transport.reads) == (1024, False)
        await asyncio.sleep(0.02)
        parser.transport.resume_reading()
        assert len(parser.bytes) == 1024
        await asyncio.sleep(0.02)
        assert (len(parser.bytes), transport.reads) == (3000, True)

    in_loop(test)


@pytest.mark.promise("a client that sends control frames alone, for half a second of parsing")
@pytest.mark.promise("One that sends data that is not a message, for half a second of parsing")
def test_who_sends_no_message_for_too_long_is_cut_off(clock: Clock) -> None:
    async def test() -> None:
        ended: list[Any] = []
        parser = Parser(clock, cost=1e-6)
        connection, transport = connected(ReadBudget(ended.append, overhead=0.02), parser)
        connection.data_received(b"p" * 100_000)
        while not transport.closing:
            await asyncio.sleep(0.001)
        assert ended == [transport]
        assert 20_000 <= len(parser.bytes) <= 30_000

    in_loop(test)


def test_who_sends_messages_is_not_cut_off(clock: Clock) -> None:
    async def test() -> None:
        parser = Parser(clock, cost=1e-6)
        connection, transport = connected(ReadBudget(unwanted, overhead=0.02), parser)
        connection.data_received(b"p" * 50_000)
        while not transport.reads:
            parser.transport.pause_reading()
            parser.transport.resume_reading()
            await asyncio.sleep(0.001)
        assert len(parser.bytes) == 50_000

    in_loop(test)


def test_a_protocol_that_takes_over_gets_later_bytes(clock: Clock) -> None:
    async def test() -> None:
        first, second = Parser(clock, pauses_after=1), Parser(clock)
        connection, _ = connected(ReadBudget(unwanted), first)
        connection.data_received(b"x" * 3000)
        first.transport.set_protocol(second)
        assert first.transport.get_protocol() is second
        first.transport.resume_reading()
        connection.data_received(b"y")
        await asyncio.sleep(0.02)
        assert (len(first.bytes), second.bytes) == (1024, b"y")

    in_loop(test)


def test_an_error_ends_its_connection_alone(clock: Clock) -> None:
    class Broken(Parser):
        def data_received(self, data: bytes) -> None:
            raise RuntimeError("broken")

    async def test() -> None:
        told: list[Any] = []
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: told.append(context))
        budget, good = ReadBudget(unwanted), Parser(clock)
        connection, transport = connected(budget, Broken(clock))
        connection.data_received(b"x" * 3000)
        connected(budget, good)[0].data_received(MESSAGE)
        assert transport.closing
        assert [str(context["exception"]) for context in told] == ["broken"]
        assert good.bytes == MESSAGE

    in_loop(test)
