"""The asyncio API over real nodes and a real master: topics, services, parameters, cancellation, views."""

from __future__ import annotations

import asyncio
import functools
import threading
from collections.abc import Callable, Iterator

import pytest

from rosproto import aio
from rosproto.codec import message_class, service_class
from rosproto.errors import ConnectionLost, RosTimeout, ServiceError
from rosproto.master import Master
from rosproto.node import Node, UnknownParameter

String = message_class("std_msgs/String")
SetBool = service_class("std_srvs/SetBool")


@pytest.fixture(scope="module")
def uri() -> Iterator[str]:
    with Master() as master:
        yield master.uri


def in_loop(test: Callable) -> Callable:
    """Run a coroutine test, 20 seconds at most."""

    @functools.wraps(test)
    def run(*args: object, **kwargs: object) -> None:
        asyncio.run(asyncio.wait_for(test(*args, **kwargs), 20))

    return run


def pair(uri: str) -> tuple[aio.Node, aio.Node]:
    return (
        aio.Node("a", master_uri=uri, anonymous=True, rosout=False),
        aio.Node("b", master_uri=uri, anonymous=True, rosout=False),
    )


@in_loop
async def test_messages_are_iterated(uri):
    one, other = pair(uri)
    async with one, other, other.subscriber("/chat", String, queue_size=100) as sub:
        pub = await one.publisher("/chat", String)
        await pub.wait_for_connection(20)
        assert pub.connections == 1
        for n in range(10):
            pub.publish(data=str(n))
        got = []
        async for message in sub:
            got.append(message.data)
            if len(got) == 10:
                break
        assert got == [str(n) for n in range(10)]
        assert sub.connections == 1
        with pytest.raises(RosTimeout, match="no message within"):
            await sub.next(timeout=0.01)
        pub.publish(data="more")
        assert (await sub.next(timeout=20)).data == "more"
        assert sub.latest.data == "more"


@in_loop
async def test_closing_the_subscriber_ends_the_iteration(uri):
    one, _ = pair(uri)
    async with one:
        sub = await one.subscriber("/quiet", String)

        async def count() -> int:
            return len([message async for message in sub])

        task = asyncio.create_task(count())
        await asyncio.sleep(0)
        await sub.close()
        assert await task == 0
        with pytest.raises(ConnectionLost):
            await sub.next(1)


@in_loop
async def test_closing_the_node_ends_the_iteration(uri):
    one, _ = pair(uri)
    await one
    sub = await one.subscriber("/quiet", String)
    changes = await one.params.subscribe("/quiet")

    async def drain(source) -> int:
        return len([item async for item in source])

    tasks = [asyncio.create_task(drain(sub)), asyncio.create_task(drain(changes))]
    await asyncio.sleep(0)
    await one.close()
    await one.close()
    assert await asyncio.gather(*tasks) == [0, 0]


@in_loop
async def test_the_oldest_messages_are_dropped_when_nobody_reads(uri):
    one, other = pair(uri)
    async with one, other, other.subscriber("/fast", String, queue_size=1) as sub:
        pub = await one.publisher("/fast", String, queue_size=100)
        await pub.wait_for_connection(20)
        for n in range(50):
            pub.publish(data=str(n))
        while sub.latest is None or sub.latest.data != "49":
            await asyncio.sleep(0.001)
        while (await sub.next(20)).data != "49":
            pass


@in_loop
async def test_a_coroutine_serves_calls_of_many_tasks_at_once(uri):
    one, other = pair(uri)
    inside, most = 0, 0

    async def handler(request):
        nonlocal inside, most
        inside += 1
        most = max(most, inside)
        while most < 5:
            await asyncio.sleep(0.001)
        inside -= 1
        return request.data, threading.current_thread().name

    async with (
        one,
        other,
        one.service_server("/set", SetBool, handler),
        other.service_client("/set", SetBool) as client,
    ):
        await client.wait(20)
        answers = await asyncio.gather(*(client.call(data=True, timeout=10) for _ in range(5)))
        assert most == 5
        assert {answer.message for answer in answers} == {threading.current_thread().name}


@in_loop
async def test_an_exception_of_a_coroutine_handler_crosses(uri):
    one, other = pair(uri)

    def handler(request):
        raise ValueError("upside down")

    async with one, other:
        await one.service_server("/flip", SetBool, handler)
        client = await other.service_client("/flip", SetBool, persistent=True)
        with pytest.raises(ServiceError, match="upside down"):
            await client.call(data=True)
        with pytest.raises(ServiceError, match="no node provides"):
            await (await other.service_client("/nowhere", SetBool)).call()
        with pytest.raises(RosTimeout):
            await other.wait_for_service("/nowhere", timeout=0.05)


@pytest.mark.parametrize("persistent", [False, True])
@in_loop
async def test_cancelling_a_call_ends_it_and_the_next_one_works(uri, persistent):
    one, other = pair(uri)
    entered, gate = asyncio.Event(), asyncio.Event()

    async def handler(request):
        if not entered.is_set():
            entered.set()
            await gate.wait()
        return True, "done"

    async with one, other:
        await one.service_server("/slow", SetBool, handler)
        client = await other.service_client("/slow", SetBool, persistent=persistent)
        call = asyncio.create_task(client.call(data=True, timeout=None))
        await entered.wait()
        call.cancel()
        with pytest.raises(asyncio.CancelledError):
            await call
        assert (await client.call(data=True, timeout=20)).message == "done"
        gate.set()


@in_loop
async def test_wait_for_limits_a_call_too(uri):
    one, other = pair(uri)
    gate = asyncio.Event()

    async def handler(request):
        await gate.wait()
        return True, ""

    async with one, other:
        await one.service_server("/slow2", SetBool, handler)
        client = await other.service_client("/slow2", SetBool)
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(client.call(data=True, timeout=None), 0.05)
        with pytest.raises(RosTimeout):
            await client.call(data=True, timeout=0.05)
        gate.set()


@in_loop
async def test_parameters_are_awaited_and_their_changes_iterated(uri):
    one, other = pair(uri)
    async with one, other, other.params.subscribe("/aio") as changes:
        await one.params.set("/aio/speed", 1.5)
        assert await other.params.get("/aio/speed") == 1.5
        assert await anext_of(changes) == ("/aio/speed", 1.5)
        assert changes.value == {"speed": 1.5}
        assert await other.params.has("/aio/speed")
        assert await other.params.search("aio") == "/aio"
        assert "/aio/speed" in await other.params.names()
        await one.params.delete("/aio")
        assert await anext_of(changes) == ("/aio", None)
        with pytest.raises(UnknownParameter):
            await one.params.get("/aio/speed")
        assert await one.params.get("/aio/speed", 3) == 3


async def anext_of(iterator):
    return await asyncio.wait_for(iterator.__anext__(), 5)


@in_loop
async def test_a_view_shares_a_node_and_leaves_it_open(uri):
    with Node("/shared", master_uri=uri, rosout=False) as node:
        async with aio.view(node) as seen:
            assert seen.name == "/shared"
            assert seen.node is node
            sub = await seen.subscriber("/talk", String)
            pub = node.publisher("/talk", String)
            await seen.publisher("/other", String)
            while not sub.connections:
                await asyncio.sleep(0.001)
            pub.publish(data="hello")
            assert (await sub.next(20)).data == "hello"
        assert not node.closed
        node.params["/still"] = True


@in_loop
async def test_closing_the_node_from_another_thread_ends_a_view(uri):
    node = Node("/shared2", master_uri=uri, rosout=False)
    seen = aio.view(node)
    sub = await seen.subscriber("/talk", String)
    waiting = asyncio.create_task(sub.next(20))
    await asyncio.sleep(0)
    await asyncio.get_running_loop().run_in_executor(None, node.close)
    with pytest.raises(ConnectionLost):
        await waiting


@in_loop
async def test_a_node_that_is_not_open_says_so():
    with pytest.raises(RuntimeError, match="open the node first"):
        aio.Node("x", master_uri="http://127.0.0.1:1").params  # noqa: B018


@in_loop
async def test_no_master_is_an_error_of_opening():
    with pytest.raises(ConnectionLost):
        await aio.Node("x", master_uri="http://127.0.0.1:1", timeout=1.0)


def test_threads_are_shared_by_calls_that_follow_each_other(uri):
    async def main() -> list[str]:
        one, other = (aio.Node(name, master_uri=uri, rosout=False) for name in ("share_a", "share_b"))
        async with one, other:
            await one.service_server("/quick", SetBool, lambda request: (True, ""))
            client = await other.service_client("/quick", SetBool, persistent=True)
            for _ in range(100):
                await client.call(data=True)
            return [t.name for t in threading.enumerate() if t.name.startswith("rosproto:aio share")]

    assert len(asyncio.run(main())) <= 4
    for thread in threading.enumerate():
        if thread.name.startswith("rosproto:aio share"):
            thread.join(20)
            assert not thread.is_alive()
