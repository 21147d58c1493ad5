"""Serves the live page to browsers on this machine, and to nobody else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import Thread
from typing import Any

from abs_engine.core.errors import OutputError
from abs_engine.live.board import Board
from abs_engine.report.document import document, safe, web

HOST, USUAL_PORT = "127.0.0.1", 8090
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; connect-src 'self'"
)
_ALIVE = 5.0  # seconds without an event, after which a browser is asked whether it is there
_BODY = """<h1>{name}</h1>
<p class="soft" id="state">connecting</p>
<div class="views"><canvas id="film"></canvas><canvas id="head"></canvas></div>
<canvas id="curves"></canvas>
<p class="soft">Pictures stay on this machine: the page is served to it alone.</p>
<noscript><p class="warning">This page needs JavaScript.</p></noscript>"""
_STYLE = """
#state { font-variant-numeric: tabular-nums; min-height: 1.5em }
.views { display: flex; flex-wrap: wrap; gap: 14px }
.views canvas { flex: 1 1 320px; min-width: 0; max-width: 100% }
#film { background: #000; align-self: flex-start } #head { height: 400px; cursor: grab }
#curves { display: block; width: 100%; height: 420px; margin-top: 14px }
"""


def page(name: str) -> str:
    """The page's HTML; `name` is what is filmed."""
    own = (files(__package__) / "web" / "live.js").read_text(encoding="utf-8")
    scripts = "\n".join((web("arrays.js"), web("heads.js"), own))
    body, end = _BODY.format(name=safe(name)), f"<script>{scripts}</script>"
    return document(f"{name}, live", body, style=_STYLE, end=end)


class _Answer(BaseHTTPRequestHandler):
    """Answers a browser."""

    protocol_version = "HTTP/1.1"

    def __init__(self, board: Board, html: str, *given: Any) -> None:
        self._board, self._html = board, html
        super().__init__(*given)

    def do_GET(self) -> None:
        """The page, the head, or events as they come."""
        name = self.headers.get("Host", "").partition(":")[0]  # without a port if it is 80
        if name not in (HOST, "localhost"):  # another site's name for this machine
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path == "/":
            self._send("text/html; charset=utf-8", self._html.encode())
        elif self.path == "/head":
            self._send("application/json", self._board.head())
        elif self.path == "/events":
            with suppress(OSError):  # the browser has gone
                self._events()
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def _send(self, kind: str, content: bytes) -> None:
        self._begin(kind, ("Content-Length", str(len(content))))
        self.wfile.write(content)

    def _begin(self, kind: str, more: tuple[str, str]) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Security-Policy", _POLICY)
        self.send_header("Cache-Control", "no-store")
        self.send_header(*more)
        self.end_headers()

    def _events(self) -> None:
        self._begin("text/event-stream", ("Connection", "close"))
        self.close_connection = True
        number = 0
        while True:
            event = self._board.after(number, _ALIVE)
            number, text = (number, b": still there\n\n") if event is None else event
            self.wfile.write(text)
            self.wfile.flush()

    def log_message(self, *_: Any) -> None:
        """Say nothing."""


@contextmanager
def served(board: Board, name: str, port: int | None) -> Iterator[str]:
    """Serve a board as long as the context lasts; yields the page's address.

    Parameters
    ----------
    port : int or None
        0 takes any that is free; None the usual one, or any if it is taken.

    Raises
    ------
    OutputError
        If the port is taken.
    """
    answer = partial(_Answer, board, page(name))
    server = _bound(answer, USUAL_PORT if port is None else port, port is None)
    Thread(target=server.serve_forever, name="page", daemon=True).start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()


def _bound(answer: Any, port: int, any_other: bool) -> ThreadingHTTPServer:
    try:
        return ThreadingHTTPServer((HOST, port), answer)
    except (OSError, OverflowError) as error:
        if any_other:
            return ThreadingHTTPServer((HOST, 0), answer)
        remedy = "give another --port; 0 takes any that is free"
        raise OutputError(f"port {port} cannot be used ({error})", remedy) from error
