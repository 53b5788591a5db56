"""Fifty threads at the same two nodes, as on a Python without the GIL: everything arrives whole, and nothing is lost
without being counted.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from rosproto import Master, Node, decode, define, encode
from rosproto.codec import message_class, service_class

SetBool = service_class("std_srvs/SetBool")
LaserScan = message_class("sensor_msgs/LaserScan")
THREADS, ROUNDS = 50, 4


def test_topics_services_parameters_and_types_from_fifty_threads() -> None:
    ranges = [float(number) for number in range(360)]
    heard: Counter[bool] = Counter()

    def on_scan(scan: LaserScan) -> None:
        heard[list(scan.ranges) == ranges] += 1

    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/serves", master_uri=master.uri, rosout=False) as serves,
        Node("/asks", master_uri=master.uri, rosout=False) as asks,
    ):
        serves.service_server("/set", SetBool, lambda request: SetBool.Response(message=str(request.data)))
        scans = serves.subscriber("/scan", LaserScan, callback=on_scan, queue_size=1000)
        publisher = asks.publisher("/scan", LaserScan, queue_size=1000)
        publisher.wait_for_connection(timeout=20)
        shared = asks.service_client("/set", SetBool, persistent=True)

        def publish(_: int) -> None:
            publisher.publish(LaserScan(ranges=ranges))

        def call(number: int) -> None:
            with asks.service_client("/set", SetBool) as client:
                for one in (client, shared):
                    assert one.call(data=number % 2 == 0, timeout=30).message == str(number % 2 == 0)

        def parameter(number: int) -> None:
            asks.params[f"/thread{number}"] = [number, {"a": 1.5}]
            assert serves.params[f"/thread{number}"] == [number, {"a": 1.5}]

        def own_type(number: int) -> None:
            type_ = define(f"threads/Type{number % 3}", "int32 a\nfloat64[] b\nstring c\n")
            assert decode(type_, encode(type_(a=number, c="y"))).a == number

        def come_and_go(number: int) -> None:
            with Node(f"/comes{number}", master_uri=master.uri, rosout=False) as node:
                node.publisher("/scan", LaserScan).close()

        jobs: list[Callable[[int], None]] = [publish, call, parameter, own_type, come_and_go]
        together = threading.Barrier(THREADS)

        def run(number: int) -> None:
            together.wait(30)
            for _ in range(ROUNDS):
                jobs[number % len(jobs)](number)

        with ThreadPoolExecutor(THREADS) as pool:
            for done in [pool.submit(run, number) for number in range(THREADS)]:
                done.result(100)
        sent = ROUNDS * THREADS // len(jobs)
        arrived = threading.Event()
        for _ in range(1000):
            if heard.total() + scans.dropped >= sent:
                break
            arrived.wait(0.02)
    assert (heard[False], heard[True] + scans.dropped) == (0, sent)
