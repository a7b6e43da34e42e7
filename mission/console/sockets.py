"""The WebSockets of a page: frames, orders, commands, stick, review (docs/design/console.md).

A socket with a malformed message is closed with 1008 and the reason. When a page disconnects, its
orders continue.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import math
import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from mission.console.admission import PROTOCOL
from mission.console.ghost import Ghosts
from mission.console.intents import Malformed, obey
from mission.console.orders import ORDERS
from mission.console.recorded import Recorded
from mission.console.vehicle import Vehicle
from mission.topside.helm import Push

LOOK_S, BEAT_S = 0.05, 1.0
POLICY = 1008
_numbers = itertools.count(1)
Said = dict[str, Any]


async def serve_frames(socket: WebSocket, vehicle: Vehicle | Recorded) -> None:
    page, board = f"page {next(_numbers)}", vehicle.board
    board.come(page, time.monotonic())

    async def answered(said: Said) -> None:
        board.answer(page, said.get("ack"), time.monotonic())

    async def send() -> None:
        while not board.is_silent(page, time.monotonic()):
            now = time.monotonic()
            if board.is_due(page, now) and (frame := vehicle.frame(page, now)):
                await socket.send_text(frame.decode())
            await asyncio.sleep(LOOK_S)
        await socket.close(POLICY, "it answers no frame")

    try:
        await _both(socket, answered, send)
    finally:
        board.go(page)


async def serve_orders(socket: WebSocket, vehicle: Vehicle) -> None:
    answers = _Answers(socket)

    async def hear(said: Said) -> None:
        name = said.get("do")
        if name not in ORDERS:
            raise Malformed(f"an order is one of {', '.join(ORDERS)}")
        vehicle.steering.drop()
        vehicle.log.note(vehicle.given.name, order=name, at=said.get("at"))

        def told(is_now: str, says: str) -> None:
            vehicle.log.note(vehicle.given.name, order=name, became=is_now, says=says)
            answers.tell(said.get("id"), is_now, says)

        ident, at = said.get("id"), said.get("at")
        pressed = isinstance(ident, int) and isinstance(at, int | float)
        vehicle.orders.give(str(name), told, (ident, at) if pressed else None)

    await _both(socket, hear, answers.send)


async def serve_commands(socket: WebSocket, vehicle: Vehicle) -> None:
    """An intent that is under way continues without its page."""
    answers = _Answers(socket)
    asked: set[asyncio.Task[None]] = set()

    async def hear(said: Said) -> None:
        def told(is_now: str, says: str, **more: Any) -> None:
            answers.tell(said.get("id"), is_now, says, **more)

        def over(task: asyncio.Task[None]) -> None:
            asked.discard(task)
            if not task.cancelled() and (error := task.exception()) is not None:
                answers.fail(error)

        task = asyncio.get_running_loop().create_task(obey(vehicle, said, told))
        asked.add(task)
        task.add_done_callback(over)

    await _both(socket, hear, answers.send)


async def serve_stick(socket: WebSocket, vehicle: Vehicle) -> None:
    page, steering = f"stick {next(_numbers)}", vehicle.steering

    async def hear(said: Said) -> None:
        now = time.monotonic()
        push, at = _push(said)
        age = time.time() - at
        steering.axes(page, push, now - max(age, 0.0) if age >= -BEAT_S else -math.inf, now)

    async def told() -> None:
        last, due = dict[str, Any](), 0.0
        while True:
            now = time.monotonic()
            says = steering.told(page, now)
            if now >= due or {**says, "age": 0} != {**last, "age": 0}:
                last, due = says, now + BEAT_S
                await socket.send_json(says)
            await asyncio.sleep(LOOK_S)

    try:
        await _both(socket, hear, told)
    finally:
        steering.let_go(page)


def _push(said: Said) -> tuple[Push | None, float]:
    """Return the push, and when the hand was there, by the page's clock. Raises Malformed."""
    at = said.get("at")
    axes = [said.get(name) for name in ("surge", "turn", "heave")]
    if isinstance(at, int | float) and said.get("held") is False:
        return None, float(at)
    if not isinstance(at, int | float) or not all(isinstance(a, int | float) for a in axes):
        raise Malformed("the stick says at, and surge, turn and heave, or held: false")
    surge, turn, heave = (min(max(float(a), -1.0), 1.0) for a in axes if a is not None)
    return Push(surge, turn, heave), float(at)


async def serve_review(socket: WebSocket, recorded: Recorded) -> None:
    async def hear(said: Said) -> None:
        recorded.steer(said)

    async def nothing() -> None:
        await asyncio.Event().wait()

    await _both(socket, hear, nothing)


async def serve_ghost(socket: WebSocket, ghosts: Ghosts, vehicle: str | None) -> None:
    """One flight at a time per page: another request, or the page's end, stops it."""
    flying: set[asyncio.Task[None]] = set()

    async def stop() -> None:
        for task in flying:
            task.cancel()
        await asyncio.gather(*flying, return_exceptions=True)
        flying.clear()

    async def hear(said: Said) -> None:
        await stop()
        if (do := said.get("do")) in ("fly", "plan"):
            flight = ghosts.fly if do == "fly" else ghosts.plan
            flying.add(asyncio.ensure_future(flight(said, vehicle, socket.send_json)))
        elif do == "cancel":
            await socket.send_json({"is": "cancelled"})
        else:
            raise Malformed("of a ghost one says fly, plan or cancel")

    async def fail() -> None:
        """Raise the errors of flights: they are the page's mistakes, and close the socket."""
        while True:
            for task in [task for task in flying if task.done()]:
                flying.discard(task)
                task.result()
            await asyncio.sleep(LOOK_S)

    try:
        await _both(socket, hear, fail)
    finally:
        await stop()


class _Answers:
    """Answers from any task, sent in order."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self._queue: asyncio.Queue[Mapping[str, Any] | Exception] = asyncio.Queue()

    def tell(self, ident: object, is_now: str, says: str, **more: Any) -> None:
        self._queue.put_nowait({"id": ident, "is": is_now, "says": says, **more})

    def fail(self, error: BaseException) -> None:
        self._queue.put_nowait(Malformed(str(error)))

    async def send(self) -> None:
        while True:
            answer = await self._queue.get()
            if isinstance(answer, Exception):
                raise answer
            await self._socket.send_json(answer)


async def _both(
    socket: WebSocket, hear: Callable[[Said], Awaitable[None]], send: Callable[[], Awaitable[None]]
) -> None:
    """Send and receive until the page is gone, or sends a malformed message."""
    await socket.accept(PROTOCOL)
    sending = asyncio.ensure_future(send())
    hearing = asyncio.ensure_future(_hear(socket, hear))
    done, waiting = await asyncio.wait((sending, hearing), return_when=asyncio.FIRST_COMPLETED)
    for task in waiting:
        task.cancel()
    await asyncio.gather(*waiting, return_exceptions=True)
    for task in done:
        error = task.exception()
        if isinstance(error, ValueError | TypeError | KeyError | OverflowError):
            await socket.close(POLICY, str(error)[:100])
        elif error is not None and not isinstance(error, WebSocketDisconnect | RuntimeError):
            raise error


def _no_number(name: str) -> float:
    """Refuse NaN and infinities, which Python reads but JSON does not allow."""
    raise Malformed(f"{name} is no number")


async def _hear(socket: WebSocket, hear: Callable[[Said], Awaitable[None]]) -> None:
    while True:
        try:
            said = json.loads(await socket.receive_text(), parse_constant=_no_number)
        except RecursionError:
            raise Malformed("that is nested too deeply") from None
        except KeyError:
            raise Malformed("text is said here, not bytes") from None
        if not isinstance(said, dict):
            raise Malformed("one JSON object is said at a time")
        await hear(said)
