"""A page in a separate process that a test can stop or kill: `python -m tests.support.web_driving_page PORT SPEED` drives the robot."""

from __future__ import annotations

import sys
import threading

from tests.support.web import PageClient

if __name__ == "__main__":
    with PageClient(int(sys.argv[1])) as page:
        page.of("hello")
        page.ready()
        page.drive(float(sys.argv[2]))
        print("driving", flush=True)
        threading.Event().wait(60.0)
