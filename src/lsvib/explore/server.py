"""Serve the page to browsers of this machine, and its exports."""

import asyncio
import errno
import logging
import webbrowser
from collections.abc import Mapping

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import Server
from bokeh.server.urls import per_app_patterns
from bokeh.server.views.ws import WSHandler
from tornado.web import RequestHandler

from lsvib.api import RigidDrive
from lsvib.engine.motion import compile_engine
from lsvib.errors import InputError, LsvibError
from lsvib.explore import answers
from lsvib.explore.answers import EXPORTS, export
from lsvib.explore.page import Page
from lsvib.explore.view import View, presets

# What is shown first: the drive on the front page of the documentation, which slides or vibrates by the start.
FRONT = View(
    RigidDrive(mass=11, support_damping=1e-3, axial_force=-10), u=0.1, over="axial_force", low=-40.0, high=-0.5
)


class Export(RequestHandler):
    """Answers ``export/<name>?<link of a view>`` with a file, or with one sentence and status 400."""

    def get(self, name: str) -> None:
        """Send the export."""
        query = {key: self.get_query_argument(key) for key in self.request.query_arguments}
        try:
            content = export(name, View.of(query))
        except LsvibError as error:
            self.set_status(400)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.write(str(error))
            return
        self.set_header("Content-Type", EXPORTS[name])
        self.set_header("Content-Disposition", f'attachment; filename="{name}"')
        self.write(content)


class PromptSocket(WSHandler):
    """Sends each piece of a message at once.

    Otherwise a small piece waits until the browser has acknowledged the piece before it, and a browser that has nothing
    to send acknowledges after 40 ms: half of the redraws took that much longer.
    """

    def open(self) -> None:
        """Open the connection to a page."""
        super().open()
        self.set_nodelay(True)


def make_server(port: int) -> Server:
    """Return a server of the page that listens already; raises ``InputError`` if the port cannot be had."""
    known = presets()
    # Bokeh has no option for the class of its sockets.
    per_app_patterns[:] = [
        (path, PromptSocket if handler is WSHandler else handler) for path, handler in per_app_patterns
    ]

    def page(document: Document) -> None:
        """Fill the page of one visitor with the view that its address asks for."""
        context = document.session_context
        arguments: Mapping[str, list[bytes]] = context.request.arguments if context else {}
        query = {key: values[-1].decode() for key, values in arguments.items() if not key.startswith("bokeh-")}
        try:
            Page(document, View.of(query) if query else FRONT, known)
        except LsvibError as error:
            document.clear()
            Page(document, View(), known, f"The link cannot be shown: {error}")

    names = "|".join(name.replace(".", r"\.") for name in EXPORTS)
    try:
        server = Server(
            {"/": Application(FunctionHandler(page))},
            address="localhost",
            port=port,
            extra_patterns=[(rf"/export/({names})", Export)],
        )
    except OSError as error:
        reason = "another program uses it" if error.errno == errno.EADDRINUSE else error.strerror
        raise InputError(f"port = {port} cannot be used: {reason}; take another one with --port.") from None
    server._tornado.websocket_origins.add(f"127.0.0.1:{server.port}")  # besides localhost; the port is known only now
    return server


def serve(port: int, show: bool) -> None:
    """Serve the page until the command is interrupted, and open it in a browser if ``show``."""
    asyncio.set_event_loop(asyncio.new_event_loop())
    logging.getLogger(WSHandler.__module__).setLevel(logging.ERROR)  # it warns when a page is closed before its answer
    server = make_server(port)
    compile_engine()  # at once, so that no page waits for a compiler
    answers.labels(FRONT.drive, answers.window_around(FRONT.drive, answers.followed(FRONT)), answers.DRAGGED)
    address = f"http://localhost:{server.port}/"
    print(f"The explorer is at {address}; Ctrl+C ends it.", flush=True)
    server.start()
    if show:
        webbrowser.open(address)
    try:
        server.io_loop.start()
    finally:
        server.stop()
