"""Map files in the format of a map server, and an HTTP server for them."""

from __future__ import annotations

import io
import threading
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from woosh_pure.maps import GridMap

__all__ = ["packed", "serving"]


def packed(folder: Path, grid: GridMap, **more: bytes) -> bytes:
    """A ZIP as a map server would have it; `name_txt=b"..."` puts further files into it."""
    folder.mkdir(exist_ok=True)
    grid.save(folder / "hall.yaml")
    found = io.BytesIO()
    with zipfile.ZipFile(found, "w", zipfile.ZIP_DEFLATED) as file:
        for path in sorted(folder.iterdir()):
            file.write(path, f"some/folder/{path.name}")
        for name, data in more.items():
            file.writestr(name.replace("_", "."), data)
    return found.getvalue()


@contextmanager
def serving(data: bytes) -> Iterator[str]:
    """A map server with /good.zip; its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200 if self.path == "/good.zip" else 404)
            self.end_headers()
            if self.path == "/good.zip":
                self.wfile.write(data)

        def log_message(self, format: str, *args: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()
