"""A program that drives on a topic, with a watchdog beside it: `python -m tests.support.watched_program MASTER`.

It publishes a velocity of 0.3 m/s ten times a second until it is ended, and says on stdout, in one line of JSON, its
watchdog's number when that is ready. What it is given on stdin it does: "fork" leaves a child
behind that holds its pipes, "close" ends in order, "standing" sends zero and disarms.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time

from rosproto.codec import encode, message_class
from rosproto.node import Node
from rosproto.watchdog import LastMessage, Watchdog, WatchedNode

TWIST = message_class("geometry_msgs/Twist")


def main() -> None:
    asked: list[str] = []

    def read() -> None:
        asked.extend(line.strip() for line in sys.stdin)

    threading.Thread(target=read, daemon=True).start()
    with Node("/program", master_uri=sys.argv[1], rosout=False) as node, Watchdog() as watchdog:
        publisher = node.publisher("/cmd_vel", TWIST, queue_size=1, linger=False)
        publisher.wait_for_connection(10.0)
        zero = LastMessage("/cmd_vel", TWIST._type, TWIST._full_text, encode(TWIST()))
        watch = watchdog.watch(WatchedNode(sys.argv[1], node.name), messages=[zero])
        velocity = TWIST()
        velocity.linear.x = 0.3
        told = 0
        while "close" not in asked:
            if "fork" in asked:
                asked.remove("fork")
                if os.fork() == 0:
                    time.sleep(30)
                    os._exit(0)
            if "standing" in asked:
                asked.remove("standing")
                velocity.linear.x = 0.0
                watch.disarm()
            publisher.publish(velocity)
            if watchdog.pid != told and watch.ready:
                told = watchdog.pid or 0
                print(json.dumps({"watchdog": told}), flush=True)
            time.sleep(0.1)
        watch.drop()


if __name__ == "__main__":
    main()
