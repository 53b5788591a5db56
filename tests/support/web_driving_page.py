"""A page in a separate process that a test can stop or kill: `python -m tests.support.web_driving_page PORT SPEED` drives
the robot with each line of its input; before it drives again, it lets go.
"""

from __future__ import annotations

import sys

from tests.support.web import PageClient

if __name__ == "__main__":
    with PageClient(int(sys.argv[1])) as page:
        page.of("hello")
        page.ready()
        for line in sys.stdin:
            if line == "again\n":
                page.let_go()
            page.drive(float(sys.argv[2]))
            print("driving", flush=True)
