"""A mirror on this machine that answers well or badly, by the first part of the path."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

#: How often ``/endless/`` repeats the file: far beyond any limit, and still no danger to the disk of who has none.
_ENDLESS = 500


class Mirror(ThreadingHTTPServer):
    """Serves the files of a folder.

    ``/good/NAME`` is the file; ``/truncated/NAME`` breaks off in the middle, ``/damaged/NAME`` has one bit flipped,
    ``/endless/NAME`` goes on and on, ``/silent/NAME`` never begins, ``/slow/NAME`` stops in the middle until `release`
    is set; anything else is not found.
    """

    daemon_threads = True

    def __init__(self, folder: Path) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.folder = folder
        self.requests: list[str] = []
        self.half_sent, self.release = threading.Event(), threading.Event()

    def base(self, manner: str = "good") -> str:
        """Return the base URL of a manner of answering."""
        return f"http://127.0.0.1:{self.server_address[1]}/{manner}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: that clients hang up is what is tested."""


class _Handler(BaseHTTPRequestHandler):
    server: Mirror

    def do_GET(self) -> None:
        self.server.requests.append(self.path)
        _, manner, name = self.path.split("/", 2)
        path = self.server.folder / name
        if manner not in ("good", "truncated", "damaged", "endless", "silent", "slow") or not path.is_file():
            self.send_error(404)
            return
        if manner == "silent":
            self.server.release.wait(60)
            return
        content = bytearray(path.read_bytes())
        if manner == "damaged":
            content[len(content) // 2] ^= 1
        self.send_response(200)
        if manner != "endless":
            self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        half = len(content) // 2 if manner in ("truncated", "slow") else len(content)
        self.wfile.write(content[:half])
        self.wfile.flush()
        self.server.half_sent.set()
        if manner == "endless":
            for _ in range(_ENDLESS):
                self.wfile.write(content)
        if manner == "slow" and self.server.release.wait(60):
            self.wfile.write(content[half:])

    def log_message(self, *_: Any) -> None:
        pass


@contextmanager
def serving(folder: Path) -> Iterator[Mirror]:
    """Serve a folder while the block runs."""
    with Mirror(folder) as mirror:
        thread = threading.Thread(target=mirror.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield mirror
        finally:
            mirror.release.set()
            mirror.shutdown()
            thread.join()


def dead_mirror() -> str:
    """Return the base URL of a port at which nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return f"http://127.0.0.1:{port}"
