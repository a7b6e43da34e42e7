"""The page's requests for charts (docs/design/console.md)."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from mission.console.asked import worked
from mission.console.charts.layer import MOST, ChartError, Layer
from mission.console.charts.shelf import Shelf
from mission.console.charts.tiles import DEEPEST, MOST_TILE, media_of

Answer = Callable[[Request], Awaitable[Response]]
ARRANGED = 1 << 16  # bytes


def chart_routes(shelf: Shelf) -> list[Route]:
    async def charts(request: Request) -> Response:
        return JSONResponse(shelf.as_objects())

    async def data(request: Request) -> Response:
        layer = shelf.find(request.path_params["name"])
        if layer is None:
            return JSONResponse({"says": "no such chart"}, 404)
        return Response(layer.data, media_type=layer.media)

    async def tile(request: Request) -> Response:
        layer = shelf.find(request.path_params["name"])
        found = b"" if layer is None else await worked(_tile, layer, request.path_params)
        kind = media_of(found)
        return Response(found, media_type=kind) if kind else Response(status_code=204)

    async def bring(request: Request) -> Response:
        body = await _body(request, MOST)
        try:
            name = await worked(shelf.bring, request.path_params["name"], body)
        except ChartError as error:  # no fault of the page: a browser reports faults on its console
            return JSONResponse({"says": str(error)})
        return JSONResponse({"name": name})

    async def arrange(request: Request) -> Response:
        body = await _body(request, ARRANGED)
        shelf.arrange(json.loads(body))
        return JSONResponse({})

    return [
        Route("/api/charts", charts),
        Route("/api/charts", _told(arrange), methods=["POST"]),
        Route("/api/charts/{name}", data),
        Route("/api/charts/{name}", _told(bring), methods=["POST"]),
        Route("/api/charts/{name}/{zoom:int}/{column:int}/{row:int}", tile),
    ]


def _tile(layer: Layer, asked: dict[str, int]) -> bytes:
    zoom, column, row = asked["zoom"], asked["column"], asked["row"]
    n = 1 << min(zoom, DEEPEST)
    if layer.tile is None or zoom > DEEPEST or not (column < n and row < n):
        return b""
    found = layer.tile(zoom, column, row) or b""
    return found if len(found) <= MOST_TILE else b""


def _told(answer: Answer) -> Answer:
    """Answer errors in words."""

    async def told(request: Request) -> Response:
        try:
            return await answer(request)
        except (ChartError, RecursionError, ValueError) as error:
            return JSONResponse({"says": str(error)}, 400)

    return told


async def _body(request: Request, most: int) -> bytes:
    pieces, size = [], 0
    async for piece in request.stream():
        pieces.append(piece)
        size += len(piece)
        if size > most:
            raise ChartError(f"more than {most >> 10} KiB: give the file to --chart instead")
    return b"".join(pieces)
