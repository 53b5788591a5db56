"""A recording served over HTTP by the standard library, correctly or with a fault."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

__all__ = ["served"]


@contextmanager
def served(
    data: bytes, lie: str = "", *, name: str = "run.bag", hold: threading.Event | None = None
) -> Iterator[tuple[str, list[int]]]:
    """Yield a URL, and the number of bytes of each answer.

    Args:
        data: Content of the file.
        lie: The fault, see below; "" for none.
        name: Name of the file.
        hold: Answers wait until it is set.

    Faults: "short" sends half of each range; "whole" advertises ranges but sends the whole file; "none" does not support
    ranges; "fail" answers 500 from the third request on; "larger" and "smaller" report a wrong size; "absent" answers
    404, "closed" 403.
    """
    sent: list[int] = []
    told = {"larger": len(data) + 5000, "smaller": len(data) - 5000}.get(lie, len(data))

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_HEAD(self) -> None:
            if not self.refused():
                self.answer(200, b"", told)

        def refused(self) -> bool:
            if hold is not None:
                hold.wait(20.0)
            if lie in ("absent", "closed"):
                self.answer({"absent": 404, "closed": 403}[lie], b"", 0)
            return lie in ("absent", "closed")

        def do_GET(self) -> None:
            if self.refused():
                return
            asked = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
            if lie == "fail" and len(sent) > 2:
                self.answer(500, b"", 0)
            elif asked is None or lie in ("whole", "none"):
                self.answer(200, data, len(data))
            else:
                first, last = int(asked[1]), min(int(asked[2]), len(data) - 1)
                if lie == "short" and last - first > 1:
                    last = (first + last) // 2
                body = data[first : last + 1]
                self.answer(206, body, len(body), f"bytes {first}-{last}/{told}")

        def answer(self, status: int, body: bytes, length: int, part: str = "") -> None:
            self.send_response(status)
            self.send_header("Content-Length", str(length))
            if lie != "none":
                self.send_header("Accept-Ranges", "bytes")
            if part:
                self.send_header("Content-Range", part)
            self.end_headers()
            try:
                self.wfile.write(body)
            except OSError:
                pass  # the client has closed the connection
            sent.append(len(body))

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/{name}", sent
    finally:
        server.shutdown()
        server.server_close()
        thread.join(5)
