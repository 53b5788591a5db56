"""A client of the Robot API that drives by velocity, in a thread or in a process that can be killed.

python -m tests.support.api_driver URL LINEAR [ANGULAR]     prints "driving" when the first velocity was accepted
"""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType
from typing import Any

from tests.support.robot_api import ApiClient

__all__ = ["ApiDriver"]

TWIST = "woosh.robot.Twist"


class ApiDriver:
    """Sends a velocity 20 times a second until told otherwise; use it in a `with` block.

    Attributes:
        client: Its connection, which nobody else uses while it sends.
        accepted: Answers with `ok` true.
        refusals: The texts of the others.
    """

    def __init__(self, url: str, linear: float = 0.2, angular: float = 0.0) -> None:
        self.client = ApiClient(url)
        self.accepted = 0
        self.refusals: list[str] = []
        self._body = {"linear": linear, "angular": angular}
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> ApiDriver:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.fall_silent()
        self.client.__exit__(kind, error, trace)

    def fall_silent(self) -> None:
        """Send nothing any more; the connection stays."""
        self._over.set()
        self._thread.join(20.0)

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                got: dict[str, Any] = self.client.answer({"type": TWIST, "body": self._body})
            except Exception:  # the connection was broken by the test
                return
            if got["ok"]:
                self.accepted += 1
            else:
                self.refusals.append(got["msg"])
            self._over.wait(0.05)


if __name__ == "__main__":
    with ApiDriver(sys.argv[1], *map(float, sys.argv[2:])) as driver:
        while not driver.accepted:
            time.sleep(0.01)
        print("driving", flush=True)
        time.sleep(600.0)
