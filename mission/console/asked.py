"""Posts of a page: one JSON object of limited size, and the error answers."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

BODY = 1 << 20  # bytes
AT_ONCE = 2  # texts and charts: more have to wait, and the vehicle's own threads stay free
Said = dict[str, Any]
P = ParamSpec("P")
T = TypeVar("T")
_workers = ThreadPoolExecutor(AT_ONCE, "page")
Answer = Callable[[Said], Awaitable[Any]]


class Refused(Exception):
    """The request cannot be done; the message says why, and what to do instead. It is no fault of
    the page: a browser reports faults on its console."""

    def __init__(self, says: str, status: int = 200) -> None:
        super().__init__(says)
        self.status = status


async def worked(work: Callable[P, T], *args: P.args, **more: P.kwargs) -> T:
    """Run ``work`` in the console's own threads. The few threads of the event loop stay free for
    the vehicles: name look-ups and checks of uploads."""
    return await asyncio.get_running_loop().run_in_executor(_workers, lambda: work(*args, **more))


async def answered(request: Request, answer: Answer, needs: str, most: int = BODY) -> Response:
    """Pass the posted object to ``answer``, which may raise Refused, and KeyError, TypeError or
    ValueError if the object is not what it ``needs``."""
    try:
        said = json.loads(await _body(request, most))
        return JSONResponse(await answer(said))
    except Refused as error:
        return JSONResponse({"says": str(error)}, error.status)
    except (ValueError, TypeError, KeyError, RecursionError):
        return JSONResponse({"says": needs}, 400)


async def _body(request: Request, most: int) -> bytes:
    body = b""
    async for piece in request.stream():
        body += piece
        if len(body) > most:
            raise Refused(f"more than {most} bytes are no mission", 413)
    return body
