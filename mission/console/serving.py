"""The console's server: on the loopback interface, until it is ended."""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
from collections.abc import Callable, Sequence

import uvicorn

from mission.console.app import Shown, application
from mission.console.charts.shelf import Shelf
from mission.topside.dives import default_folder

HOST = "127.0.0.1"
SAID = 2 << 20  # bytes of one message of a page: an upload
LEAVE_S = 2
# uvicorn's message for a WebSocket that was refused by an HTTP answer (admission)
ANSWERED = "ASGI callable returned without completing handshake."


def listen(port: int) -> socket.socket:
    """``port`` 0: any free one. Raises OSError."""
    return socket.create_server((HOST, port))


async def serve(
    listening: socket.socket,
    made: Callable[[], Sequence[Shown]],
    ready: Callable[[str], None],
    server: Callable[[uvicorn.Server], None] = lambda server: None,
    charts: Shelf | None = None,
) -> None:
    """Serve until SIGINT or SIGTERM. ``made`` is called in the event loop. ``ready`` gets the
    page's address once the server answers, ``server`` the object that can end it."""
    port, token = listening.getsockname()[1], secrets.token_urlsafe(24)
    shelf = charts or Shelf(default_folder())
    app = application(made(), shelf, port, token)
    config = uvicorn.Config(
        app, log_level="warning", access_log=False, server_header=False, ws_max_size=SAID,
        ws_per_message_deflate=False, timeout_graceful_shutdown=LEAVE_S, lifespan="on",
    )  # fmt: skip
    logging.getLogger("uvicorn.error").addFilter(_is_news)
    running = uvicorn.Server(config)
    server(running)
    serving = asyncio.ensure_future(running.serve(sockets=[listening]))
    while not running.started and not serving.done():
        await asyncio.sleep(0.01)
    if running.started:
        ready(f"http://{HOST}:{port}/#{token}")
    await serving
    shelf.close()


def _is_news(record: logging.LogRecord) -> bool:
    """Drop this message: a page of another origin could fill the terminal with it."""
    return record.msg != ANSWERED
