"""Live replay: meshcat's own server, bound to the loopback address 127.0.0.1 only.

Plain meshcat calls ``app.listen(port)``, which listens on all interfaces. Here its server gets a socket that is already
bound, and it answers only requests to this machine's own name. ``/`` is the replay page, connected to the server;
``/static/`` is meshcat's own page with the same arms. meshcat's ZeroMQ socket, which any program of this machine could
draw in, is bound inside this process, so that no port of it is open.
"""

from __future__ import annotations

import asyncio
import errno
import socket
import threading
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import tornado.httpserver
import tornado.ioloop
import tornado.web
import umsgpack  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import joint_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import reason_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replay_page import meshcat_folder, replay_html
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs

with warnings.catch_warnings():  # meshcat imports a deprecated module of pyzmq that it does not use
    warnings.filterwarnings("ignore", message="zmq.eventloop.ioloop is deprecated", category=DeprecationWarning)
    from meshcat.servers.tree import find_node
    from meshcat.servers.zmqserver import StaticFileHandlerNoCache, WebSocketHandler, ZMQWebSocketBridge

LOOPBACK = "127.0.0.1"
DEFAULT_PORT = 7000
_OWN_NAMES = r"(127\.0\.0\.1|localhost)"
_STARTS_WITHIN = 30.0
"""Longest start of the server's thread [s]."""


class LiveReplay:
    """A running server; `close()` stops it, and it is a context manager."""

    def __init__(self, page: str, shown: Sequence[ReplayedRun], sockets: Sequence[socket.socket]) -> None:
        self.port = int(sockets[0].getsockname()[1])
        self.url = f"http://{LOOPBACK}:{self.port}/"
        self._shown, self._page, self._sockets = shown, page, sockets
        self._ready, self._fault = threading.Event(), list[Exception]()
        self._thread = threading.Thread(target=self._work, name="meshcat", daemon=True)
        self._thread.start()
        self._ready.wait(_STARTS_WITHIN)
        if self._fault:
            raise self._fault[0]

    def show(self, q: ArrayLike, run: int = 0) -> None:
        """Move the arm of run `run` to q (n,) [rad or m] on every open page; raises `ShapeError`."""
        arm = self._shown[run].arm
        commands = list(replay_page.pose_commands(arm, joint_array("q", q, arm.n), run))
        self._loop.add_callback(self._draw, commands)

    def wait(self) -> None:
        """Wait until the server is closed."""
        while self._thread.is_alive():
            self._thread.join(0.2)

    def close(self) -> None:
        """Stop listening; may be called twice."""
        if self._thread.is_alive():
            self._loop.add_callback(self._loop.stop)
            self._thread.join(_STARTS_WITHIN)

    def __enter__(self) -> LiveReplay:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _work(self) -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        self._loop = tornado.ioloop.IOLoop.current()
        app = _LoopbackApplication(self._page, self._sockets)
        try:
            self._bridge = _Bridge(app)
            for i, one in enumerate(self._shown):
                self._draw(replay_page.arm_commands(one, i))
            self._loop.add_callback(self._ready.set)
            self._loop.start()
            self._bridge.stop()
        except Exception as fault:  # raised in the thread that started the server
            self._fault.append(fault)
        finally:
            app.stop()
            self._loop.close(all_fds=True)
            self._ready.set()

    def _draw(self, commands: Iterable[replay_page.Command]) -> None:
        for command in commands:
            self._bridge.draw(command)


def serve(
    runs: Sequence[Run], arms: Arm | Sequence[Arm], *, port: int = DEFAULT_PORT, **page_options: Any
) -> LiveReplay:
    """Start a live replay on 127.0.0.1 and return at once.

    Parameters
    ----------
    runs, arms
        As for `lwr_dyn.pages.replay.replay_page.replay_html`, which also lists `page_options`.
    port : int
        0 for any free port; `LiveReplay.port` is the actual one.

    Raises
    ------
    OptionError
        The port is in use, not allowed, or outside 0..65535; and as `replay_html`.
    ShapeError
        As `replay_html`.
    """
    page = replay_html(runs, arms, live=True, **page_options)
    shown = replayed_runs(runs, arms, page_options.get("labels"))
    return LiveReplay(page, shown, bound_sockets(port))


def bound_sockets(port: int) -> list[socket.socket]:
    """A listening socket at a port of 127.0.0.1, 0 for any free one; raises `OptionError` as `serve`."""
    if not 0 <= port <= 65535:
        raise OptionError("port", port, "0..65535, 0 takes a free one")
    bound = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    bound.setblocking(False)
    try:
        bound.bind((LOOPBACK, port))
        bound.listen()
    except OSError as fault:
        bound.close()
        reason = "taken" if fault.errno == errno.EADDRINUSE else reason_of(fault)
        raise OptionError("port", f"{port} is {reason}", "a free port, or 0 for any free one") from None
    return [bound]


class _LoopbackApplication(tornado.web.Application):
    """meshcat's pages and websocket on sockets that are already bound, for requests to our own names only."""

    def __init__(self, page: str, sockets: Sequence[socket.socket]) -> None:
        super().__init__()
        self._page, self._sockets = page, sockets
        self._server = tornado.httpserver.HTTPServer(self)

    def open_to(self, bridge: _Bridge) -> None:
        """Add the routes, which need the bridge."""
        static = {"path": str(meshcat_folder()), "default_filename": "index.html"}
        routes: list[Any] = [
            (r"/static/(.*)", StaticFileHandlerNoCache, static),
            (r"/", _PageOrSocket, {"bridge": bridge, "page": self._page}),
        ]
        self.add_handlers(_OWN_NAMES, routes)

    def listen(self, *_: Any, **__: Any) -> tornado.httpserver.HTTPServer:
        """Serve our own sockets; the port that meshcat passes is ignored."""
        self._server.add_sockets(self._sockets)
        return self._server

    def stop(self) -> None:
        """Stop listening."""
        self._server.stop()
        for bound in self._sockets:
            bound.close()


class _PageOrSocket(WebSocketHandler):  # type: ignore[misc]
    """The replay page for browsers, and the websocket of that page."""

    def initialize(self, page: str) -> None:
        self._page_text = page

    async def get(self, *args: Any, **kwargs: Any) -> None:
        if self.request.headers.get("Upgrade", "").lower() == "websocket":
            await super().get(*args, **kwargs)
            return
        self.set_header("Cache-Control", "no-store")
        await self.finish(self._page_text)

    def open(self, *_: str, **__: str) -> None:
        self.bridge.websocket_pool.add(self)
        self.bridge.send_scene(self)

    def on_message(self, message: str | bytes) -> None:
        """Pages send nothing that is asked for; what comes is not looked at."""

    def on_close(self) -> None:
        self.bridge.websocket_pool.discard(self)


class _Bridge(ZMQWebSocketBridge):  # type: ignore[misc]
    """meshcat's bridge on our application, without a ZeroMQ port."""

    def __init__(self, app: _LoopbackApplication) -> None:
        self._loopback_app = app
        port = int(app._sockets[0].getsockname()[1])
        super().__init__(zmq_url=f"inproc://lwr_dyn_{port}", host=LOOPBACK, port=port)

    def make_app(self) -> _LoopbackApplication:
        """Our application instead of meshcat's."""
        self._loopback_app.open_to(self)
        return self._loopback_app

    def draw(self, command: replay_page.Command) -> None:
        """Store a command for future pages and send it to open ones."""
        path = [name for name in command["path"].split("/") if name]
        data = umsgpack.packb(dict(command))
        node = find_node(self.tree, path)
        if command["type"] == "set_object":
            node.object, node.properties = data, []
        else:
            node.transform = data
        self.forward_to_websockets([command["type"], command["path"], data])

    def stop(self) -> None:
        """Close the pages' sockets and the bridge's."""
        for page in list(self.websocket_pool):
            page.close()
        self.zmq_stream.close(linger=0)
