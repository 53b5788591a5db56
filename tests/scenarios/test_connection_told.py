"""`chassis.connected` and `chassis.on_connection`: whether the robot is heard, for a window or a page."""

from __future__ import annotations

import asyncio
import queue
import threading

from tests.support.ports import unused_port
from woosh_pure import Chassis, SimulatedChassis


def test_a_lost_robot_is_told_and_a_found_one(sim, until) -> None:
    """Silence counts, though the link is up: so does a cable that was pulled."""
    told: queue.SimpleQueue[tuple[bool, str]] = queue.SimpleQueue()
    with Chassis(sim.master_uri) as chassis:
        until(lambda: chassis.connected)
        off = chassis.on_connection(lambda on: told.put((on, threading.current_thread().name)))
        assert told.get(timeout=5.0) == (True, "woosh:connection")
        sim.fall_silent(60.0)
        assert told.get(timeout=5.0)[0] is False
        assert not chassis.connected
        sim.reset()
        assert told.get(timeout=5.0)[0] is True
        off()
    assert told.empty()


def test_a_robot_that_ends_and_comes_again_is_told(until) -> None:
    """And the end of the Chassis itself, at last."""
    port = unused_port()
    told: list[bool] = []
    with SimulatedChassis(full_graph=False, port=port) as sim, Chassis(sim.master_uri) as chassis:
        chassis.on_connection(told.append)
        until(lambda: told == [True])
        sim.close()
        until(lambda: told == [True, False])
        with SimulatedChassis(full_graph=False, port=port):
            until(lambda: told == [True, False, True], 20.0)
            chassis.close()
            until(lambda: told == [True, False, True, False])
    assert not chassis.connected
    until(lambda: all(thread.name != "woosh:connection" for thread in threading.enumerate()))


def test_a_robot_that_is_not_there_is_not_connected(until) -> None:
    told: list[bool] = []
    chassis = Chassis(f"http://127.0.0.1:{unused_port()}", timeout=0.5)
    assert not chassis.connected
    chassis.on_connection(told.append)
    until(lambda: told == [False])
    chassis.close()


def test_an_exception_in_the_callback_is_logged_and_it_goes_on(sim, chassis, caplog, until) -> None:
    told: list[bool] = []

    def fail(on: bool) -> None:
        told.append(on)
        raise LookupError("of the program")

    chassis.on_connection(fail)
    until(lambda: "LookupError" in caplog.text)
    sim.fall_silent(60.0)
    until(lambda: told == [True, False])


def test_in_asyncio_it_is_awaited_and_called_in_the_loop(sim) -> None:
    async def program() -> bool:
        heard: asyncio.Future[bool] = asyncio.get_running_loop().create_future()
        async with Chassis(sim.master_uri).aio as robot:
            assert await robot.connected
            off = robot.on_connection(heard.set_result)
            try:
                return await asyncio.wait_for(heard, 60.0)
            finally:
                off()

    assert asyncio.run(program())
