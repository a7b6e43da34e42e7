"""The console as a web application: its paths, and the page's own files."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from functools import partial
from importlib.resources import files
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from mission import __version__
from mission.console import planning, plans
from mission.console.admission import Admission
from mission.console.asked import Refused, Said, answered, worked
from mission.console.charts.shelf import Shelf
from mission.console.charts.web import chart_routes
from mission.console.ghost import Ghosts
from mission.console.intents import FRESH_S
from mission.console.recorded import Recorded
from mission.console.sockets import (
    serve_commands,
    serve_frames,
    serve_ghost,
    serve_orders,
    serve_review,
    serve_stick,
)
from mission.console.vehicle import Vehicle
from mission.model.shipped import shipped_missions
from mission.topside.panels import FIX_S, REPORT_S

KINDS = {
    "html": "text/html", "js": "text/javascript", "css": "text/css", "svg": "image/svg+xml",
    "png": "image/png",
}  # fmt: skip
STALE = {"intent": FRESH_S, "report": REPORT_S, "fix": FIX_S}
Shown = Vehicle | Recorded
Serve = Callable[[WebSocket, Any], Awaitable[None]]


def application(shown: Sequence[Shown], charts: Shelf, port: int, token: str) -> ASGIApp:
    console = _Console({one.ident: one for one in shown})
    live, recorded, both = (Vehicle,), (Recorded,), (Vehicle, Recorded)
    routes = [
        Route("/", _file),
        Route("/page/{name:path}", _file),
        Route("/api/setup", console.setup),
        Route("/api/missions", _missions),
        Route("/api/words", _words),
        Route("/api/check", console.check, methods=["POST"]),
        Route("/api/edit", _edit, methods=["POST"]),
        Route("/api/import", console.take, methods=["POST"]),
        Route("/api/vehicles/{ident}/diff", console.diff, methods=["POST"]),
        Route("/api/vehicles/{ident}/plan", console.plan),
        Route("/api/vehicles/{ident}/planned", console.planned),
        Route("/api/vehicles/{ident}/doctor", console.doctor),
        Route("/api/vehicles/{ident}/events", console.events),
        Route("/api/vehicles/{ident}/hindsight", console.hindsight),
        *chart_routes(charts),
        WebSocketRoute("/ws/frames", partial(console.socket, serve_frames, both)),
        WebSocketRoute("/ws/orders", partial(console.socket, serve_orders, live)),
        WebSocketRoute("/ws/commands", partial(console.socket, serve_commands, live)),
        WebSocketRoute("/ws/stick", partial(console.socket, serve_stick, live)),
        WebSocketRoute("/ws/ghost", console.ghost),
        WebSocketRoute("/ws/review", partial(console.socket, serve_review, recorded)),
    ]
    return Admission(Starlette(routes=routes, lifespan=console.lifespan), port, token)


class _Console:
    def __init__(self, shown: Mapping[str, Shown]) -> None:
        self._shown, self._ghosts = shown, Ghosts()

    @contextlib.asynccontextmanager
    async def lifespan(self, app: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.ensure_future(one.run()) for one in self._shown.values()]
        tasks.append(asyncio.ensure_future(worked(plans.get_ready)))
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._ghosts.end()

    async def setup(self, request: Request) -> Response:
        vehicles = [one.about() for one in self._shown.values()]
        return JSONResponse({"version": __version__, "vehicles": vehicles, "stale_s": STALE})

    async def plan(self, request: Request) -> Response:
        one = self._shown.get(request.path_params["ident"])
        return _nothing("no such vehicle") if one is None else JSONResponse(one.plan())

    async def planned(self, request: Request) -> Response:
        """Return the plan on board, in still water."""
        one = self._shown.get(request.path_params["ident"])
        plan = {} if one is None else one.plan()
        if one is None or not plan["digest"]:
            return _nothing("what is on board is not known here")
        vehicle = one.given.vehicle if isinstance(one, Vehicle) else one.vehicle
        said = {"text": plan["text"], "source": ""}
        return JSONResponse({**await self._ghosts.planned(said, vehicle), "digest": plan["digest"]})

    async def doctor(self, request: Request) -> Response:
        """Returns the doctor's findings in the vehicle file of a vehicle under way."""
        one = self._shown.get(request.path_params["ident"])
        name = one.given.vehicle or one.plan()["vehicle"] if isinstance(one, Vehicle) else ""
        return JSONResponse(await asyncio.to_thread(plans.of_vehicle, name) if name else [])

    async def events(self, request: Request) -> Response:
        return await self._of_recording(request, lambda one: one.recording.events())

    async def hindsight(self, request: Request) -> Response:
        return await self._of_recording(request, lambda one: one.hindsight())

    async def _of_recording(self, request: Request, ask: Callable[[Recorded], Any]) -> Response:
        one = self._shown.get(request.path_params["ident"])
        if not isinstance(one, Recorded):
            return _nothing("a recording has this, a vehicle under way has not")
        return JSONResponse(await asyncio.to_thread(ask, one))

    @property
    def _vehicle(self) -> str | None:
        """The vehicle file of the first live vehicle; missions are checked for it."""
        live = (one for one in self._shown.values() if isinstance(one, Vehicle))
        return next((one.given.vehicle for one in live), None)

    async def check(self, request: Request) -> Response:
        async def judged(said: Said) -> Any:
            text, source = str(said["text"]), str(said["source"])
            return await worked(plans.checked, text, source, self._vehicle)

        return await answered(request, judged, "a check needs text and source")

    async def take(self, request: Request) -> Response:
        async def taken(said: Said) -> Any:
            return await planning.imported(said, self._vehicle)

        return await answered(request, taken, planning.IMPORT_NEEDS, planning.IMPORT)

    async def diff(self, request: Request) -> Response:
        one = self._shown.get(request.path_params["ident"])

        async def compared(said: Said) -> Any:
            text, source = str(said["text"]), str(said["source"])
            board = "" if one is None else str(one.plan()["text"])
            if not board:
                raise Refused("what is on board is not known here")
            return await worked(planning.difference, text, source, board, self._vehicle)

        return await answered(request, compared, "a difference needs text and source")

    async def ghost(self, socket: WebSocket) -> None:
        await serve_ghost(socket, self._ghosts, self._vehicle)

    async def socket(self, serve: Serve, of: tuple[type[Shown], ...], socket: WebSocket) -> None:
        one = self._shown.get(socket.query_params.get("vehicle", ""))
        if isinstance(one, of):
            await serve(socket, one)
        else:
            await socket.close()


async def _edit(request: Request) -> Response:
    return await answered(request, planning.edited, planning.EDIT_NEEDS)


async def _words(request: Request) -> Response:
    return JSONResponse(await planning.words())


async def _missions(request: Request) -> Response:
    found = await asyncio.to_thread(_shipped)
    return JSONResponse(found)


def _shipped() -> list[dict[str, str]]:
    return [
        {"name": name, "text": path.read_text(encoding="utf-8")}
        for name, path in shipped_missions().items()
    ]


async def _file(request: Request) -> Response:
    """Serve a file of the page's folder in the package, and nothing else."""
    name = request.path_params.get("name", "index.html")
    kind = KINDS.get(name.rpartition(".")[2])
    parts = name.split("/")
    if kind is None or any(part.startswith(".") or not part for part in parts):
        return _nothing("the page has no such file")
    path = files("mission.console").joinpath("page", *parts)
    if not path.is_file():
        return _nothing("the page has no such file")
    return Response(path.read_bytes(), media_type=kind)


def _nothing(says: str) -> Response:
    return JSONResponse({"says": says}, 404)
