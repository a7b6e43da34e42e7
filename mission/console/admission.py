"""Access control: only the page that was opened from here, and only under our own host name.

    Host is ours --no--> 421      Origin, where there is one, is ours --no--> 403
    the page's own files --> all others need the token: a header, or of a WebSocket a subprotocol

A page of another origin can make the browser send requests, but cannot know the token. A page that
points a name of its own at 127.0.0.1 comes with another Host. No cookie is used: on the loopback
interface, cookies of one port are sent to all ports. Every answer forbids the page to load anything
from anywhere else.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Iterable

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

PROTOCOL = "auvmission"  # subprotocol of the WebSockets
TOKEN = "token."  # the subprotocol with the token begins so
OPEN = ("/", "/favicon.ico")
FILES = "/page/"
HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
        "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "cache-control": "no-store",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}
Headers = Iterable[tuple[bytes, bytes]]


class Admission:
    """ASGI wrapper around ``app``."""

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self._app, self._token = app, token
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        status, why = self._refusal(scope)
        if not status and scope["type"] == "http":
            await self._answer(scope, receive, _with_headers(send))
        elif not status:
            await self._app(scope, receive, _with_headers(send))
        else:  # also for a WebSocket: an HTTP answer instead of opening it
            await JSONResponse({"says": why}, status)(scope, receive, _with_headers(send))

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """If the console ends before the answer has begun, say so."""
        has_begun = False

        async def sent(message: Message) -> None:
            nonlocal has_begun
            has_begun = True
            await send(message)

        try:
            await self._app(scope, receive, sent)
        except asyncio.CancelledError:
            if not has_begun:
                await JSONResponse({"says": "the console ends"}, 503)(scope, receive, send)

    def _refusal(self, scope: Scope) -> tuple[int, str]:
        """Return the status, 0 if access is allowed, and the reason."""
        hosts, origins = _all(scope["headers"], b"host"), _all(scope["headers"], b"origin")
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return 421, "this console answers to 127.0.0.1 and localhost alone"
        socket = scope["type"] == "websocket"
        if (origins or socket) and origins != [f"http://{hosts[0]}"]:
            return 403, "a page of another origin gets nothing here"
        path = scope["path"]
        if not socket and (path in OPEN or path.startswith(FILES)):
            return 0, ""
        if not self._shows_token(scope["headers"], socket):
            return 403, "open the page by the address that auvmission console has printed"
        return 0, ""

    def _shows_token(self, headers: Headers, socket: bool) -> bool:
        if socket:
            offered = ",".join(_all(headers, b"sec-websocket-protocol")).split(",")
            shown = [p.strip().removeprefix(TOKEN) for p in offered if p.strip().startswith(TOKEN)]
        else:
            told = _all(headers, b"authorization")
            shown = [t.removeprefix("Bearer ") for t in told if t.startswith("Bearer ")]
        given = shown[0] if len(shown) == 1 else ""
        return secrets.compare_digest(given.encode(), self._token.encode())


def _all(headers: Headers, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in headers if key == name]


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"].endswith("http.response.start"):
            own = [(k.encode(), v.encode()) for k, v in HEADERS.items()]
            message = {**message, "headers": [*message["headers"], *own]}
        await send(message)

    return sent
