"""Serve the page to browsers of this machine, and its exports."""

import asyncio
import errno
import logging
import webbrowser
from asyncio import get_running_loop
from collections.abc import Mapping
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.models import Div
from bokeh.server.server import Server
from bokeh.server.urls import per_app_patterns
from bokeh.server.views.ws import WSHandler
from tornado.httputil import HTTPServerRequest
from tornado.web import RequestHandler

from lsvib.api import Drive
from lsvib.errors import InputError, LsvibError
from lsvib.explore import answers
from lsvib.explore.page import THREAD, Page
from lsvib.explore.view import View

MOST_PAGES = 12  # open at once, those included that were closed a moment ago
# What is shown first: the drive on the front page of the documentation, which slides or vibrates by the start.
FRONT = View(Drive(mass=11, support_damping=1e-3, axial_force=-10), u=0.1, over="axial_force", low=-40.0, high=-0.5)


class Export(RequestHandler):
    """Answers ``export/<name>?<link of a view>`` with a file, or with one sentence and status 400."""

    async def get(self, name: str) -> None:
        """Send the export."""
        query = {key: self.get_query_argument(key) for key in self.request.query_arguments}
        try:
            view = View.of(query)
            content = await get_running_loop().run_in_executor(THREAD, answers.export, name, view)
        except LsvibError as error:
            self.set_status(400)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.write(str(error))
            return
        self.set_header("Content-Type", answers.EXPORTS[name])
        self.set_header("Content-Disposition", f'attachment; filename="{name}"')
        self.write(content)


class Refused(RequestHandler):
    """Answers a request that was sent to another name than that of this machine.

    A page of another site, whose name has been rebound to this machine, would otherwise be served as one of ours.
    """

    def prepare(self) -> None:
        """Refuse it."""
        self.set_status(403)
        self.finish("The explorer answers to localhost and 127.0.0.1 only.")


class PromptSocket(WSHandler):
    """Sends each piece of a message at once.

    Otherwise a small piece waits until the browser has acknowledged the piece before it, and a browser that has nothing
    to send acknowledges after 40 ms: half of the redraws took that much longer.
    """

    def open(self) -> None:
        """Open the connection to a page."""
        super().open()
        self.set_nodelay(True)


def make_server(port: int, front: View) -> Server:
    """Return a server that listens already, of a page with ``front``; ``InputError`` if the port cannot be had."""
    # Bokeh has no option for the class of its sockets.
    per_app_patterns[:] = [
        (path, PromptSocket if handler is WSHandler else handler) for path, handler in per_app_patterns
    ]

    def page(document: Document) -> None:
        if len(server.get_sessions("/")) >= MOST_PAGES:
            document.title = "Too many pages of the explorer are open"
            document.add_root(Div(text=f"{document.title}; close some, then reload this one."))
            return
        context = document.session_context
        arguments: Mapping[str, list[bytes]] = context.request.arguments if context else {}
        query = {key: values[-1].decode() for key, values in arguments.items() if not key.startswith("bokeh-")}
        try:
            view, complaint = (View.of(query) if query else front), ""
        except LsvibError as error:
            view, complaint = View(), f"The link cannot be shown: {error}"
        Page(document, view, complaint)

    names = "|".join(name.replace(".", r"\.") for name in answers.EXPORTS)
    try:
        server = Server(
            {"/": Application(FunctionHandler(page))},
            address="localhost",
            port=port,
            check_unused_sessions_milliseconds=2_000,
            unused_session_lifetime_milliseconds=10_000,
            extra_patterns=[(rf"/export/({names})", Export)],
        )
    except OSError as error:
        reason = "another program uses it" if error.errno == errno.EADDRINUSE else error.strerror
        raise InputError(f"port = {port} cannot be used: {reason}; choose another one with --port.") from None
    application, hosts = server._tornado, {f"localhost:{server.port}", f"127.0.0.1:{server.port}"}
    application.websocket_origins.update(hosts)  # the port is known only now
    find = application.find_handler

    def find_handler(request: HTTPServerRequest, **more: Any) -> Any:
        return find(request, **more) if request.host in hosts else application.get_handler_delegate(request, Refused)

    application.find_handler = find_handler  # the one place that every path goes through
    return server


def serve(port: int, show: bool, front: View) -> None:
    """Serve the page, first with ``front``, until the command is interrupted, and open it in a browser if ``show``."""
    asyncio.set_event_loop(asyncio.new_event_loop())
    logging.getLogger(WSHandler.__module__).setLevel(logging.ERROR)  # it warns when a page is closed before its answer
    server = make_server(port, front)
    answers.make_ready(front)
    address = f"http://localhost:{server.port}/"
    print(f"The explorer is at {address}; Ctrl+C ends it.", flush=True)
    server.start()
    if show:
        webbrowser.open(address)
    try:
        server.io_loop.start()
    finally:
        server.stop()
