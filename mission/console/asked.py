"""What a page posts: one JSON object of a bounded size, and what it is told where that is wrong."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

BODY = 1 << 20  # bytes
AT_ONCE = 2  # texts, charts: more take turns, and the vehicle's own threads stay free
Said = dict[str, Any]
P = ParamSpec("P")
T = TypeVar("T")
_workers = ThreadPoolExecutor(AT_ONCE, "page")
Answer = Callable[[Said], Awaitable[Any]]


class Refused(Exception):
    """What somebody asks for cannot be done; it says why, and what instead. No fault of the page:
    a browser tells faults on its console."""

    def __init__(self, says: str, status: int = 200) -> None:
        super().__init__(says)
        self.status = status


async def worked(work: Callable[P, T], *args: P.args, **more: P.kwargs) -> T:
    """Runs ``work`` in threads of the console's own. The few threads of the event loop are left to
    the vehicles, for looking up names and judging uploads."""
    return await asyncio.get_running_loop().run_in_executor(_workers, lambda: work(*args, **more))


async def answered(request: Request, answer: Answer, needs: str, most: int = BODY) -> Response:
    """``answer`` gets what was posted; it may raise Refused, and KeyError, TypeError or ValueError
    where it is not what it ``needs``."""
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
